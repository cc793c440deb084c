"""What a saved checkpoint may say: it comes from a stranger, and is looked at before anything of it is used."""

"""Our own small LLaVA: its network, its tokenizer, its encoder and its training aid."""

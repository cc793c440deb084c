"""What leaves this machine for the Hub: datasets and policies, each with its card, through one mechanism."""

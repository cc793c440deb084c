"""Pretrained image-text models of the Hub: loading, the stop token, what is frozen, their processors."""

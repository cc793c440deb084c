"""Rendered views and words in, a heatmap for each view and features out: one network for each design.

``view_network`` is what they share; the blocks, the transformer and the upsampling are what they are built from.
"""

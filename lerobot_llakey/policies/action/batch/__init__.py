"""What is read from a batch in the data contract, checked on the way: the coloured cloud, the hand, the labels.

Augmentation stands here too, as it moves all of these together. Nothing in this room is learned.
"""

"""Words: which texts steer the policy, how they become word vectors, and which colours they mean.

The word vectors come from an encoder trained along, or from a frozen model of the Hub.
"""

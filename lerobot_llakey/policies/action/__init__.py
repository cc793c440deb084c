"""The action policy: configuration, modeling and processor for LeRobot, and the stage that the rooms meet in.

``batch`` reads observations and labels, ``text`` the words, ``views`` renders, ``networks`` look, ``heads`` tell the
pose; ``designs`` says which of these make up a published design.
"""

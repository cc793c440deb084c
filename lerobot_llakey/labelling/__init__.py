"""Keyframes and instructions by hand: a person watches an episode, corrects its keyframes and says what is done."""

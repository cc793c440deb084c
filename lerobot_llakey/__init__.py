"""LLaKey for LeRobot: importing this package registers its environment and its policies with LeRobot."""

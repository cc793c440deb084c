"""What may come between asking for an action and its execution; users choose by the setting ``disturbance``."""

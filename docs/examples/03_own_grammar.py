"""Basic actions in words of your own: what a grammar file allows, implies and refuses.

From the repository root: python docs/examples/03_own_grammar.py
"""

from pathlib import Path

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.grammar import Grammar
from lerobot_llakey.policies.hierarchy.configuration_llakey import LlakeyConfig

FILE = Path(__file__).with_name("my_grammar.yaml")
TEXTS = (
    "press the red button",
    "push the red button down",
    "pour the milk into the blue bowl",
    "reach for the far side of the cup",
    "grasp the cup",
)


def main() -> None:
    grammar = Grammar.load(FILE)
    for text in TEXTS:
        try:
            instruction = grammar.parse(text)
        except LlakeyError as error:
            print(f"{text!r} is refused: {error}")
            continue
        gripper = {True: "open", False: "closed", None: "either way"}[grammar.templates[instruction.template].gripper]
        print(f"{text!r} is {instruction.template}{instruction.arguments}, gripper {gripper}")

    # A dataset that was annotated with --grammar=my_grammar.yaml hands it to the policies trained on it. Elsewhere:
    policy = LlakeyConfig(grammar=str(FILE), commander="list", instructions=["press the red button"], device="cpu")
    print(f"\nwhere nothing was ever commanded, this policy does: {policy.fallback!r}")

    print("free text takes any sentence:", Grammar.load("free").canonical("Would you  mind the red button?"))


if __name__ == "__main__":
    main()

"""Settings of the chat backend."""

from __future__ import annotations

from dataclasses import dataclass

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.saved.own import users_own

UNNAMED = ""
"""In place of a server's address: a loaded checkpoint's, until the user gives one."""
GUIDANCE = ("forms", "known", "none")
IMAGE_FORMATS = ("png", "jpeg")


@dataclass
class ChatSettings:
    """How a hosted model is asked, on top of its address and name.

    What names a variable or a dataset is the user's own: saved in a checkpoint it is shown and ignored.

    Attributes:
        api_key_env: environment variable that holds the API key. Where it is unset a placeholder is sent, which servers
            of one's own accept. The key itself is no setting: it is never saved, logged or shown.
        guidance: what the system message says about answers besides the paper's words: "forms" lists the forms of basic
            actions, "known" the instructions known from the dataset, "none" leaves the paper's bare prompt.
        examples: number of solved examples shown before each question, drawn from a keysteps dataset.
        examples_repo_id, examples_root: that dataset; not one of the episodes that are evaluated.
        examples_seed: which of its samples are drawn.
        temperature: of sampling; None leaves it to the server, which some hosted models insist on.
        max_tokens_field: what the server calls the longest answer: "max_tokens" or, for newer hosted models,
            "max_completion_tokens".
        image_format: "png" or "jpeg".
        timeout_s: seconds for a whole answer at each attempt, from connecting to its last byte.
        max_attempts: attempts at a request before it counts as unanswered.
        max_parallel: requests under way at once; one request a row of a batch.
    """

    api_key_env: str = users_own("OPENAI_API_KEY")
    guidance: str = "forms"
    examples: int = users_own(0)
    examples_repo_id: str | None = users_own(None)
    examples_root: str | None = users_own(None)
    examples_seed: int = 0
    temperature: float | None = 0.0
    max_tokens_field: str = "max_tokens"
    image_format: str = "png"
    timeout_s: float = 60.0
    max_attempts: int = 5
    max_parallel: int = 4

    def __post_init__(self) -> None:
        for name, choices in (("guidance", GUIDANCE), ("image_format", IMAGE_FORMATS)):
            if getattr(self, name) not in choices:
                raise LlakeyError(
                    f"Expected `chat.{name}` out of {choices}, got {getattr(self, name)!r}; pick one of these."
                )
        if self.timeout_s <= 0 or self.max_attempts < 1 or self.max_parallel < 1 or self.examples < 0:
            raise LlakeyError(
                "Expected `chat` with timeout_s > 0, max_attempts >= 1, max_parallel >= 1 and examples >= 0, got "
                f"{self.timeout_s}, {self.max_attempts}, {self.max_parallel} and {self.examples}; correct them."
            )
        if self.examples and self.examples_repo_id is None:
            raise LlakeyError(
                f"Expected `chat.examples_repo_id` to name a keysteps dataset for {self.examples} examples, got none; "
                "give it, with chat.examples_root where it lies on this disk."
            )


def check_address(base_url: str | None, model: str | None) -> None:
    """Refuse an incomplete address, and one that holds a secret, since addresses are saved and shown.

    Raises:
        LlakeyError: see above.
    """
    if not model:
        raise LlakeyError(
            "Expected `model` to name the server's model with backend=chat, got none; give for example "
            "--policy.model=gpt-4o."
        )
    if not base_url:
        return
    scheme, separator, rest = base_url.partition("://")
    if not separator or scheme not in ("http", "https"):
        raise LlakeyError(
            f"Expected `base_url` like http://127.0.0.1:8000/v1, got one that starts with {scheme[:8]!r}; write it so."
        )
    if "@" in rest.partition("/")[0] or "?" in rest:
        raise LlakeyError(
            "Expected `base_url` without user name, password or query, got one with; put the key into the environment "
            "variable that chat.api_key_env names."
        )

"""Settings of the chat backend, and secrets: which address holds one, which text repeats one."""

from __future__ import annotations

import base64
import re
from dataclasses import dataclass

from lerobot_llakey.errors import LlakeyError
from lerobot_llakey.saved.own import users_own

UNNAMED = ""
"""In place of a server's address: a loaded checkpoint's, until the user gives one."""
GUIDANCE = ("forms", "known", "none")
IMAGE_FORMATS = ("png", "jpeg")
PIECE = 8
"""Characters of a secret that are enough to betray it."""
_NO_SIGN = re.compile(r"[^0-9a-z]")


POLICY_OPTIONS = "--policy."
"""How the options of a policy's chat model begin."""


@dataclass
class ChatSettings:
    """How requests to a hosted model are made, besides its address and name.

    Names of variables and datasets are the user's own: those in a checkpoint are shown and ignored.

    Attributes:
        api_key_env: environment variable that holds the API key. If it is unset, a placeholder is sent, which a local
            server accepts. The key itself is not a setting: it is never saved, logged or shown.
        guidance: what the system message adds about answers to the paper's prompt: "forms" lists the templates of basic
            actions, "known" the instructions known from the dataset, "none" adds nothing.
        examples: number of solved examples before each question, drawn from a keysteps dataset.
        examples_repo_id, examples_root: that dataset; it must not hold episodes of the evaluation.
        examples_seed: which of its samples are drawn.
        temperature: of sampling; None leaves it to the server, as some hosted models require.
        max_tokens_field: the server's name for the longest answer: "max_tokens" or, for newer hosted models,
            "max_completion_tokens".
        image_format: "png" or "jpeg".
        timeout_s: seconds for a whole answer in each attempt, from connecting to its last byte.
        max_attempts: attempts before a request counts as unanswered.
        max_parallel: requests in flight at once; each row of a batch is one request.
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


def check_address(base_url: str | None, model: str | None, options: str = POLICY_OPTIONS) -> None:
    """Refuse an incomplete address, and one with a secret in it, since addresses are saved and shown.

    Args:
        base_url: None is OpenAI's own.
        model: the model's name there.
        options: how an error begins the names of these two options.

    Raises:
        LlakeyError: see above.
    """
    if not model:
        raise LlakeyError(
            "Expected `model` to name the server's model with backend=chat, got none; give for example "
            f"{options}model=gpt-4o."
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


def repeats(text: str, secret: str) -> bool:
    """Whether a text contains ``PIECE`` successive characters of a secret: forwards, backwards, in base64 or in hex.

    Letter case and signs other than letters and digits are ignored. A shorter secret counts only as a whole; an empty
    one is in no text.
    """
    plain = _NO_SIGN.sub("", text.lower())
    return any(piece in plain for form in _forms(secret) for piece in _pieces(form))


def _forms(secret: str) -> list[str]:
    raw = secret.encode()
    # base64 reads three bytes at a time: the letters depend on how many stand before the secret.
    shifted = [base64.b64encode(bytes(before) + raw)[before + 1 if before else 0 :].decode() for before in range(3)]
    plain = [secret, raw.hex(), *shifted]
    return [form for one in plain if (form := _NO_SIGN.sub("", one.lower()))] + [
        form for one in plain if (form := _NO_SIGN.sub("", one[::-1].lower()))
    ]


def _pieces(form: str) -> list[str]:
    size = min(PIECE, len(form))
    return [form[start : start + size] for start in range(len(form) - size + 1)]

"""Encoder of a pretrained model through its own processor, and the stop token that the processor must know."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor
from transformers import LlavaProcessor, PaliGemmaProcessor, PreTrainedModel

from lerobot_llakey.policies.command.encoding import Encoder, end_answers_with
from lerobot_llakey.policies.command.prompt import STOP, Prompt

LLAVA_FORM = "{system} USER: {request} ASSISTANT:"
"""LLaVA-1.5's conversation form (that of Vicuna v1)."""
PLAIN_FORM = "{system}\n{request}"


class ProcessorEncoder(Encoder):
    """Encoder of a pretrained model, through its own processor.

    Args:
        processor: a transformers processor of images and text, whose tokenizer knows the stop token.
        template: the conversation form, with the slots ``{system}`` and ``{request}``; None takes the default described
            for ``ModelSettings.prompt_format``.
        settings: passed to the processor at every call.
    """

    def __init__(self, processor: Any, template: str | None = None, settings: Mapping[str, Any] | None = None) -> None:
        self.processor = processor
        self.settings = dict(settings or {})
        self.pad_id = processor.tokenizer.pad_token_id
        self.stop_id = processor.tokenizer.convert_tokens_to_ids(STOP)
        # PaliGemma attends both ways in the prompt, and from left to right in answers, of type 1.
        self.answer_type_id = int(isinstance(processor, PaliGemmaProcessor))
        self._image_token = getattr(processor, "image_token", "<image>")
        if template is None and isinstance(processor, LlavaProcessor):
            template = LLAVA_FORM
        elif template is None and not getattr(processor, "chat_template", None):
            template = PLAIN_FORM
        self.template = template
        # PaliGemma's processor ends every prompt with a line break.
        ends_with_space = self.text(Prompt(("front",), ""))[-1:].isspace() or self.answer_type_id == 1
        self._before_answer = "\n" if ends_with_space else ": "

    def text(self, prompt: Prompt) -> str:
        """A prompt in the processor's form, with one placeholder an image."""
        if self.template is not None:
            return prompt.text(self._image_token, self.template)
        return self.processor.apply_chat_template(prompt.conversation, add_generation_prompt=True, tokenize=False)

    def prompts(self, images: Tensor, prompts: Sequence[Prompt]) -> dict[str, Tensor]:
        pixels = (images * 255).round().to(torch.uint8).cpu()
        texts = [self.text(prompt) for prompt in prompts]
        begin = self.processor.tokenizer.bos_token
        # A template may write the begin token itself; the tokenizer would add another.
        begins = {"add_special_tokens": False} if begin and all(text.startswith(begin) for text in texts) else {}
        inputs = self.processor(
            text=texts,
            images=[list(row) for row in pixels],
            return_tensors="pt",
            padding=True,
            padding_side="left",
            **begins,
            **self.settings,
        )
        return {key: value.to(images.device) for key, value in inputs.items() if key != "labels"}

    def answer(self, text: str) -> list[int]:
        # Tokenised with the text before it: many tokenizers treat the first word of a text differently.
        encode = self.processor.tokenizer.encode
        before = encode(self._before_answer.rstrip(" "), add_special_tokens=False)
        ids = encode(self._before_answer + text, add_special_tokens=False)
        ids = ids[len(before) :] if ids[: len(before)] == before else encode(text, add_special_tokens=False)
        return [*ids, self.stop_id]

    def decode(self, ids: Iterable[int]) -> str:
        kept: list[int] = []
        for token in ids:
            if token == self.stop_id:
                break
            kept.append(token)
        return " ".join(self.processor.tokenizer.decode(kept, skip_special_tokens=True).split())


def add_stop_token(model: PreTrainedModel, processor: Any) -> None:
    """Add the paper's stop token to a pretrained model's tokenizer and embeddings, and end generation at it.

    A new token starts as the mean of the others in the embedding and the output layer. So every process and every later
    run gets the same weights from the same model, which an adapter needs: it is saved without them.
    """
    tokenizer = processor.tokenizer
    is_new = STOP not in tokenizer.get_vocab()
    tokenizer.add_special_tokens({"additional_special_tokens": [STOP]}, replace_extra_special_tokens=False)
    stop_id = tokenizer.convert_tokens_to_ids(STOP)
    embeddings: Any = model.get_input_embeddings()
    known = min(embeddings.num_embeddings, stop_id)
    if len(tokenizer) > embeddings.num_embeddings:
        model.resize_token_embeddings(len(tokenizer), mean_resizing=False)
    if is_new:
        _start_as_mean(model, stop_id, known)
    if tokenizer.pad_token_id is None:
        tokenizer.pad_token = tokenizer.eos_token or STOP
    end_answers_with(model, stop_id, tokenizer.pad_token_id)


@torch.no_grad()
def _start_as_mean(model: PreTrainedModel, stop_id: int, known: int) -> None:
    layers: list[Any] = [model.get_input_embeddings(), model.get_output_embeddings()]
    for layer in layers:
        if layer is not None and layer.weight.device.type != "meta":
            layer.weight[known:] = layer.weight[:known].float().mean(0).to(layer.weight.dtype)

import pytest

from lerobot_llakey.policies.command.pretrained.loading import load_pretrained


def test_missing_folder_is_named():
    with pytest.raises(ValueError, match="'/no/such/model', which does not exist"):
        load_pretrained("/no/such/model")


def test_folder_without_a_model_is_named(tmp_path):
    with pytest.raises(ValueError, match="Expected `model` to name an image-text model"):
        load_pretrained(str(tmp_path))

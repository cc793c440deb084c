"""``llakey push``: put a dataset or a policy on the Hub, with its card.

llakey push --repo_id=me/demonstrations --root=outputs/demonstrations
llakey push --repo_id=me/llakey --policy_path=outputs/llakey --results=outputs/table/results.json --private=false
"""

from dataclasses import dataclass
from pathlib import Path

from lerobot_llakey.cli.command_line import with_options
from lerobot_llakey.cli.errors import one_sentence
from lerobot_llakey.errors import LlakeyError


@dataclass
class PushConfig:
    """Options of ``llakey push``.

    Attributes:
        repo_id: name on the Hub, as user/name.
        root: folder of a dataset; by default LeRobot's home folder.
        policy_path: folder of a policy's checkpoint, in place of a dataset.
        results: results.json of llakey table or llakey demo, or eval_info.json of lerobot-eval, for a policy's card; by
            default a results.json beside the policy's weights.
        private: whether only you see it; by default only simulated data is public.
        license: by the Hub's name for it (apache-2.0, cc-by-4.0, ...); by default apache-2.0 for simulated data and
            policies, none for recordings.
    """

    repo_id: str
    root: Path | None = None
    policy_path: Path | None = None
    results: Path | None = None
    private: bool | None = None
    license: str | None = None

    def check(self) -> None:
        """Refuse options that do not go together.

        Raises:
            LlakeyError: if a dataset and a policy are named, or results of a dataset.
        """
        if self.policy_path is not None and self.root is not None:
            raise LlakeyError("Expected --root or --policy_path, got both; push the dataset and the policy in turn.")
        if self.policy_path is None and self.results is not None:
            raise LlakeyError("Expected --results with --policy_path, got it with a dataset; leave it out.")


@with_options
def run(config: PushConfig) -> None:
    """Push, and say where it is."""
    config.check()
    if config.policy_path is None:
        from lerobot_llakey.sharing.push_dataset import push_dataset

        address, private = push_dataset(config.repo_id, config.root, private=config.private, license=config.license)
    else:
        from lerobot_llakey.sharing.push_policy import push_policy

        address, private = push_policy(
            config.repo_id, config.policy_path, config.results, private=config.private, license=config.license
        )
    print(f"pushed: {address} ({'private' if private else 'public'})")


def main() -> None:
    """Run the verb with the options of the command line."""
    with one_sentence():
        run()

import torch

from lerobot_llakey.policies.command.decoding.trie import KnownAnswers, Trie


def test_trie_offers_what_may_follow():
    trie = Trie([[1, 2, 9], [1, 3, 9], [4, 9]])
    assert sorted(trie.next_tokens([])) == [1, 4]
    assert sorted(trie.next_tokens([1])) == [2, 3]
    assert trie.next_tokens([1, 2]) == [9]
    assert trie.next_tokens([1, 2, 9]) == [] == trie.next_tokens([7])


def test_only_known_answers_keep_their_scores():
    constraint = KnownAnswers(Trie([[1, 2, 9], [4, 9]]), prompt_length=2, pad_id=0)
    scores = torch.arange(10.0).repeat(3, 1)
    ids = torch.tensor([[5, 5, 1], [5, 5, 4], [5, 5, 9]])
    result = constraint(ids, scores)
    assert [row.isfinite().nonzero().flatten().tolist() for row in result] == [[2], [9], [0]]
    assert result[0, 2] == scores[0, 2]

"""Which patch of each picture is the ball: one path, and no leaps to another ball and back."""

from dataclasses import replace

from tracks import BALL

from tracking.blob import Blob
from tracking.path import best_path, guess_radius, sharper


def rising(number: int) -> Blob:
    return replace(BALL, y=501 - 11.0 * number)


def resting(number: int) -> Blob:
    """The ball below, struck a moment ago: it moves a little, and looks as round."""
    return replace(BALL, x=118.5, y=545 - 1.0 * number, contrast=95)


def test_a_path_does_not_leap_to_another_ball_and_back() -> None:
    frames = [[rising(number)] for number in range(4)]
    frames += [[resting(number), rising(number)] for number in range(4, 14)]
    for number in (4, 5, 6):  # its shadow clings to it a little
        frames[number][1] = replace(rising(number), width=46, height=47, area=1700)
    frames += [[rising(number)] for number in range(14, 24)]
    assert best_path(frames, 20) == [0] * 4 + [1] * 10 + [0] * 10


def test_a_ball_that_is_hidden_for_some_frames_stays_missing_there() -> None:
    frames = [[rising(number)] if not 8 <= number < 11 else [] for number in range(20)]
    assert best_path(frames, 20) == [-1 if 8 <= number < 11 else 0 for number in range(20)]


def test_what_moves_farthest_and_clearest_tells_the_radius() -> None:
    ghost = replace(BALL, y=100, width=10, height=10, area=78)
    assert guess_radius([[rising(number), ghost] for number in range(20)]) == 21
    assert guess_radius([[ghost] for _ in range(20)]) is None


def test_a_round_piece_of_a_hand_outvotes_no_ball() -> None:
    frames = [[rising(number)] for number in range(24)]
    for number, frame in enumerate(frames):  # brighter than the ball, and trembling
        tremble = 3.0 * (-1) ** number
        frame.append(replace(BALL, x=200, y=40 + tremble, width=14, height=14, area=154, contrast=200))
    assert guess_radius(frames) == 21


def test_a_knuckle_at_rest_is_left_at_once_or_through_a_smear_but_a_ball_that_is_let_go_is_not() -> None:
    held = [[replace(BALL, y=50)] for _ in range(30)]
    fallen = [[replace(BALL, y=150 + 0.5 * number**2)] for number in range(20)]
    smear = [[replace(BALL, y=80)]]
    assert best_path([*held, *fallen], 20) == [-1] * 30 + [0] * 20
    assert best_path([*held, *smear, *fallen], 20) == [-1] * 31 + [0] * 20
    slow_camera = [[replace(BALL, y=50 + 24.0 * number**2)] for number in range(1, 6)]
    assert best_path([*held, *slow_camera], 20) == [0] * 35


def test_sharp_pictures_are_chosen_all_along_a_path_not_where_a_hand_holds_the_ball() -> None:
    held, falling = 20, 80
    path = {k: replace(BALL, width=42, height=42 + 0.2 * max(k - held, 0)) for k in range(held + falling)}
    chosen = sharper(path, 9)
    assert len(chosen) == 9
    assert sum(k < held for k in chosen) <= 4
    assert max(chosen) <= (held + falling) // 2

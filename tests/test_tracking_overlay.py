"""What was found is drawn on the recording, where it was found, and can be read."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from film_discs import HEIGHT, RADIUS_PX, WIDTH, film
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tracking.contact_sheet import PANEL_PX
from tracking.encode import write_video
from tracking.overlay import Moment, Outline, Overlay, Scene
from tracking.overlay_film import as_png, write_overlay
from tracking.overlay_marks import FINE_SHIFT, LEAST_SIDE, MOST_LENGTH, MOST_SIDE, resized, whole_brush
from tracking.video import Recording, open_recording, read_frames

Picture = NDArray[np.uint8]
COUNT = 30
ZOOM = 3  # of a picture 160 px high
WAY = np.column_stack((np.linspace(40, 280, COUNT), np.full(COUNT, 80.0)))
SEEN = Outline(frame=np.arange(COUNT), centre=WAY, radius=np.full(COUNT, float(RADIUS_PX)))
HIT = Moment(time=12 / 240, place=np.array([139.3, 80.0]), words="impact")
UNIT = st.floats(0, 1)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A white disc that crosses a brown board."""
    return open_recording(film(tmp_path_factory.mktemp("overlay") / "disc.mp4", [WAY]))


def drawn(recording: Recording, overlay: Overlay, path: Path) -> list[Picture]:
    """Pictures of the overlay, decoded again."""
    write_overlay(recording, overlay, path)
    film = open_recording(path)
    return [frame.image.astype(int) for frame in read_frames(replace(film, genuine=film.times >= 0))]


def orange(picture: Picture) -> NDArray[np.bool_]:
    """Where the first ball's colour is, as far as the film keeps colours."""
    blue, green, red = np.moveaxis(picture, 2, 0)
    return np.asarray((red > 160) & (red - blue > 110) & (green - blue > 50) & (red - green > 20))


def test_every_frame_is_shown_and_the_film_plays_in_slow_motion(recording: Recording, tmp_path: Path) -> None:
    write_overlay(recording, Overlay(outlines=(SEEN,)), tmp_path / "film.mp4")
    again = open_recording(tmp_path / "film.mp4")
    assert recording.genuine.all()
    assert (again.times.size, again.capture_fps) == (COUNT, pytest.approx(30))
    rows, columns = again.size
    assert (columns, rows % 2) == (ZOOM * WIDTH, 0)
    assert rows > ZOOM * HEIGHT
    data = (tmp_path / "film.mp4").read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")


def test_the_outline_lies_on_the_ball(recording: Recording, tmp_path: Path) -> None:
    picture = drawn(recording, Overlay(outlines=(SEEN,)), tmp_path / "film.mp4")[20]
    rows, columns = np.nonzero(orange(picture))
    centre = (WAY[20] + 0.5) * ZOOM
    distance = np.hypot(columns - centre[0], rows - centre[1])
    assert np.count_nonzero(np.abs(distance - ZOOM * RADIUS_PX) < 4) > 50
    assert columns.max() - centre[0] == pytest.approx(ZOOM * RADIUS_PX, abs=4)


def test_a_frame_in_which_nothing_was_seen_shows_no_outline(recording: Recording, tmp_path: Path) -> None:
    seen = Outline(frame=SEEN.frame[20:], centre=WAY[20:], radius=SEEN.radius[20:])
    pictures = drawn(recording, Overlay(outlines=(seen,)), tmp_path / "film.mp4")
    assert not orange(pictures[10]).any()
    assert orange(pictures[25]).any()


def test_text_is_light_on_a_dark_strip_however_bright_the_picture(tmp_path: Path) -> None:
    write_video(tmp_path / "white.mp4", iter([np.full((200, 160, 3), 250, np.uint8)] * 12), 50)
    overlay = Overlay(outlines=(SEEN,), scenes=(Scene(lines=("before -1.234 m/s", "after 1.000 m/s")),))
    picture = drawn(open_recording(tmp_path / "white.mp4"), overlay, tmp_path / "film.mp4")[3]
    strip = picture[3 * 200 :]
    assert np.median(strip) < 30
    assert np.count_nonzero(strip.min(axis=2) > 180) > 200


def test_a_long_line_is_made_to_fit(tmp_path: Path, recording: Recording) -> None:
    overlay = Overlay(outlines=(SEEN,), scenes=(Scene(lines=("velocity of the ball " * 12,)),))
    strip = drawn(recording, overlay, tmp_path / "film.mp4")[3][ZOOM * HEIGHT :]
    assert strip[:, -8:].max() < 60
    assert strip[:, ZOOM * WIDTH // 2 :].max() > 100


def test_a_scene_lasts_until_the_next() -> None:
    first, second = Scene(lines=("impact 1",)), Scene(since=0.5, lines=("impact 2",))
    overlay = Overlay(outlines=(), scenes=(first, second))
    assert [overlay.scene_at(time) for time in (0.0, 0.49, 0.5, 9.0)] == [first, first, second, second]


@pytest.mark.parametrize(
    ("moments", "rows", "columns"),
    [((HIT,), 3, 3), ((HIT, Moment(time=0.1, place=HIT.place, words="again")), 2, 4), ((), 3, 3)],
)
def test_the_sheet_shows_eight_or_nine_frames(
    recording: Recording, tmp_path: Path, moments: tuple[Moment, ...], rows: int, columns: int
) -> None:
    overlay = Overlay(outlines=(SEEN,), scenes=(Scene(moments=moments),))
    sheet = write_overlay(recording, overlay, tmp_path / "film.mp4")
    assert sheet is not None
    assert sheet.shape[1] // (PANEL_PX + 4) == columns
    assert sheet.shape[0] // (PANEL_PX + 4) == rows
    assert as_png(sheet).startswith(b"\x89PNG")


def test_a_path_that_leaves_the_picture_or_is_unknown_costs_nothing(
    recording: Recording, tmp_path: Path
) -> None:
    far = np.array([[np.nan, 0.0], [-1e4, 50.0], [1e5, 60.0]])
    overlay = Overlay(outlines=(SEEN,), scenes=(Scene(curves=(far, far[:1]), moments=(HIT,)),))
    assert len(drawn(recording, overlay, tmp_path / "film.mp4")) == COUNT


def test_odd_sides_are_made_even() -> None:
    picture = np.zeros((361, 405, 3), np.uint8)
    assert resized(picture, whole_brush(picture.shape)).shape == (362, 406, 3)


@given(rows=st.integers(100, 2000), columns=st.integers(100, 2000), place=st.tuples(UNIT, UNIT))
def test_what_is_drawn_lies_on_what_it_marks_at_any_size(
    rows: int, columns: int, place: tuple[float, float]
) -> None:
    """Small pictures are enlarged, large ones made smaller."""
    x, y = 20 + place[0] * (columns - 40), 20 + place[1] * (rows - 40)
    picture = np.zeros((rows, columns, 3), np.uint8)
    cv2.circle(picture, (round(x), round(y)), 12, (255, 255, 255), -1)
    brush = whole_brush(picture.shape)
    seen = resized(picture, brush)
    weights = cv2.moments(seen[..., 0])
    found = weights["m10"] / weights["m00"], weights["m01"] / weights["m00"]
    told = brush.fine(np.array([round(x), round(y)])) / 2**FINE_SHIFT
    np.testing.assert_allclose(found, told, atol=0.6)
    assert seen.shape[1] >= LEAST_SIDE
    assert min(seen.shape[:2]) <= MOST_SIDE + 1
    assert max(seen.shape[:2]) <= MOST_LENGTH + 1

"""Ways in which old scripts eat the image: a plain list of signed bytes, bottom row first."""

from __future__ import annotations

import array
import time
from collections.abc import Iterator

import numpy as np
import pytest
from idiom_world import connect, handle, idiom_world, start_stepped

import simx_client as vrep

pytestmark = [pytest.mark.slow, pytest.mark.gl]

WIDTH, HEIGHT = 8, 6


@pytest.fixture(scope="module")
def camera() -> Iterator[tuple[int, int]]:
    """In front of a blue wall whose left lower quarter is red: RGB values near 0 and near 255, which is -1."""
    with idiom_world():
        clientID = connect()
        start_stepped(clientID)
        yield clientID, handle(clientID, "colour")


def blocking(camera: tuple[int, int], options: int = 0) -> list[int]:
    res, resolution, image = vrep.simxGetVisionSensorImage(*camera, options, vrep.simx_opmode_blocking)
    assert (res, resolution) == (0, [WIDTH, HEIGHT])
    return image


def assert_upright(picture: np.ndarray) -> None:
    """Red in the left lower corner, blue elsewhere, as one looks at it."""
    assert picture.shape == (HEIGHT, WIDTH, 3)
    assert picture.dtype == np.uint8
    assert list(picture[-1, 0] > 200) == [True, False, False]
    assert list(picture[0, 0] > 200) == list(picture[-1, -1] > 200) == [False, False, True]


def test_uint8_resize_flip(camera: tuple[int, int]) -> None:
    image = blocking(camera)
    img = np.array(image, dtype=np.uint8)
    img.resize([HEIGHT, WIDTH, 3])
    img = np.flipud(img)
    assert_upright(img)


def test_uint8_reshape_and_rows_by_slices(camera: tuple[int, int]) -> None:
    image = blocking(camera)
    img = np.reshape(np.array(image, np.uint8), (HEIGHT, WIDTH, 3))[::-1, :, :]
    assert_upright(img)


def test_no_type_then_arithmetic_then_astype(camera: tuple[int, int]) -> None:
    img = np.array(blocking(camera))
    img[img < 0] += 256
    assert img.min() >= 0
    assert img.max() <= 255
    assert_upright(np.flip(img.reshape(HEIGHT, WIDTH, 3).astype(np.uint8), 0))


def test_scaled_then_the_sign_put_right(camera: tuple[int, int]) -> None:
    color_img = np.asarray(blocking(camera))
    color_img.shape = (HEIGHT, WIDTH, 3)
    color_img = color_img.astype(float) / 255
    color_img[color_img < 0] += 1
    color_img *= 255
    assert_upright(np.flipud(color_img).round().astype(np.uint8))


def test_128_added_to_a_float_image(camera: tuple[int, int]) -> None:
    img = np.array(blocking(camera), dtype=np.float32) + 128
    assert 0 <= img.min() <= img.max() <= 255


def test_256_added_in_the_list_itself(camera: tuple[int, int]) -> None:
    image = blocking(camera)
    for i in range(len(image)):
        if image[i] < 0:
            image[i] = image[i] + 256
    assert_upright(np.flipud(np.array(image, dtype=np.uint8).reshape(HEIGHT, WIDTH, 3)))


def test_256_added_by_map(camera: tuple[int, int]) -> None:
    pixels = list(map(lambda x: x + 256 if x < 0 else x, blocking(camera)))  # noqa: C417 - as people wrote it
    assert bytes(pixels) == np.array(blocking(camera), np.uint8).tobytes()


def test_array_of_signed_bytes_for_a_buffer(camera: tuple[int, int]) -> None:
    """Input of PIL's frombuffer: unsigned values would raise here."""
    image_byte_array = array.array("b", blocking(camera))
    picture = np.frombuffer(image_byte_array.tobytes(), np.uint8).reshape(HEIGHT, WIDTH, 3)
    assert_upright(np.flipud(picture))


def test_channels_picked_by_steps(camera: tuple[int, int]) -> None:
    image = blocking(camera)
    red = [image[i] for i in range(0, len(image), 3)]
    blue = image[2::3]
    assert red[0] == image[0]
    assert red[0] & 0xFF > 200 > blue[0] & 0xFF
    assert red[-1] & 0xFF < 60 < 200 < blue[-1] & 0xFF


def test_grey_values_are_compared_with_0_and_minus_1(camera: tuple[int, int]) -> None:
    image = blocking(camera, 1)
    assert len(image) == WIDTH * HEIGHT
    assert all(type(pixel) is int and -128 <= pixel <= 127 for pixel in image)
    white = sum(1 for pixel in image if pixel == -1)
    assert (white, image.count(0)) == (0, 0)  # a third of 255 for both colours
    assert max(image) < 100


def test_the_edited_list_is_handed_back(camera: tuple[int, int]) -> None:
    clientID, sensor = camera
    image = blocking(camera)
    for i in range(0, len(image), 3):
        image[i : i + 3] = [-1, -1, 0]  # yellow
    assert vrep.simxSetVisionSensorImage(clientID, sensor, image, 0, vrep.simx_opmode_oneshot) in (0, 1)
    assert list(blocking(camera)) == [-1, -1, 0] * WIDTH * HEIGHT
    vrep.simxSynchronousTrigger(clientID)  # the next sensing phase overwrites it
    assert_upright(np.flipud(np.array(blocking(camera), np.uint8).reshape(HEIGHT, WIDTH, 3)))


def test_without_an_image_both_lists_are_empty(camera: tuple[int, int]) -> None:
    clientID, _ = camera
    res, resolution, image = vrep.simxGetVisionSensorImage(clientID, 777776, 0, vrep.simx_opmode_blocking)
    assert res == vrep.simx_return_remote_error_flag
    assert (resolution, image) == ([], [])


def test_wait_for_the_first_image_then_buffer_in_the_loop(camera: tuple[int, int]) -> None:
    clientID, sensor = camera
    res, resolution, image = vrep.simxGetVisionSensorImage(clientID, sensor, 0, vrep.simx_opmode_streaming)
    assert (res, resolution, image) == (vrep.simx_return_novalue_flag, [], [])
    frames = 0
    while frames < 3:
        vrep.simxSynchronousTrigger(clientID)
        res, resolution, image = vrep.simxGetVisionSensorImage(clientID, sensor, 0, vrep.simx_opmode_buffer)
        if res == vrep.simx_return_ok:
            frames += 1
            img = np.array(image, dtype=np.uint8)
            img.resize([resolution[1], resolution[0], 3])
        elif res == vrep.simx_return_novalue_flag:
            time.sleep(0)
    assert_upright(np.flipud(img))
    vrep.simxGetVisionSensorImage(clientID, sensor, 0, vrep.simx_opmode_discontinue)


def test_the_image_in_the_buffer_is_of_the_step_that_was_triggered(camera: tuple[int, int]) -> None:
    """As in V-REP, where sensing belonged to the step; a robot that follows a line drives by it."""
    clientID, sensor = camera
    wall = handle(clientID, "wall")
    vrep.simxGetVisionSensorImage(clientID, sensor, 1, vrep.simx_opmode_streaming)
    for step in range(6):
        away = step % 2 == 0
        vrep.simxSetObjectPosition(clientID, wall, -1, (6, 30 if away else 0, 1), vrep.simx_opmode_oneshot)
        vrep.simxSynchronousTrigger(clientID)
        res, _, image = vrep.simxGetVisionSensorImage(clientID, sensor, 1, vrep.simx_opmode_buffer)
        assert res == vrep.simx_return_ok
        assert (max(pixel & 0xFF for pixel in image) < 60) is away, step
    vrep.simxGetVisionSensorImage(clientID, sensor, 1, vrep.simx_opmode_discontinue)

"""The files of OpenVINS, VINS, ORB-SLAM3 and OKVIS2 in the parser that these programs use, where it is installed."""

import pytest

from sigmatau import Choices, NoiseModel, export

cv2 = pytest.importorskip("cv2")  # pip install opencv-python-headless

N, K = {"gyro": 1.5e-4, "accel": 2.5e-3}, {"gyro": 3.5e-6, "accel": 4.5e-5}
RATE = 200.0
CONTINUOUS = [N["gyro"], N["accel"], K["gyro"], K["accel"]]
DISCRETE = [*((2 * RATE) ** 0.5 * N[s] for s in ("gyro", "accel")), *(RATE**0.5 * K[s] for s in ("gyro", "accel"))]


@pytest.mark.parametrize(
    ("name", "parent", "keys", "expected"),
    [
        (
            "openvins",
            "imu0",
            (
                *("gyroscope_noise_density", "accelerometer_noise_density"),
                *("gyroscope_random_walk", "accelerometer_random_walk"),
            ),
            CONTINUOUS,
        ),
        ("orb-slam3", "", ("IMU.NoiseGyro", "IMU.NoiseAcc", "IMU.GyroWalk", "IMU.AccWalk"), CONTINUOUS),
        ("okvis2", "imu_parameters", ("sigma_g_c", "sigma_a_c", "sigma_gw_c", "sigma_aw_c"), CONTINUOUS),
        ("vins", "", ("gyr_n", "acc_n", "gyr_w", "acc_w"), DISCRETE),
    ],
)
def test_opencv_reads_the_models_numbers(tmp_path, name, parent, keys, expected):
    terms = {s: {"random_walk": N[s], "rate_random_walk": K[s]} for s in N}
    model = NoiseModel(channels={f"{s}_{a}": terms[s] for s in N for a in "xyz"})
    text = export(model, to=name, choices=Choices(filter_rate=RATE))
    path = tmp_path / "imu.yaml"
    path.write_text(text if text.startswith("%YAML:1.0") else f"%YAML:1.0\n{text}")  # a part of a file that begins so
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    root = storage.getNode(parent) if parent else storage.root()
    assert [root.getNode(key).real() for key in keys] == pytest.approx(expected, rel=1e-12)
    if name == "okvis2":  # which stops at a number that is not real
        assert all(root.getNode(key).isReal() for key in (*keys, "sigma_bg", "sigma_ba", "g"))
    if name == "openvins":
        assert root.getNode("update_rate").real() == RATE
        assert root.getNode("T_i_b").size() == 4

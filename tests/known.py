"""Known answers: numbers computed independently or to 40 digits, each with its source and number of digits."""

import hashlib
import signal

import numpy as np


def seed_of(name: str) -> int:
    """Seed from the name of a case: neither chosen nor changed."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:7], "big")


def nbs14() -> np.ndarray:
    """The 1000-point set of NIST SP 1065, section 12.4: a linear congruential generator."""
    n, values = 1234567890, []
    for _ in range(1000):
        values.append(n / 2147483647)
        n = 16807 * n % 2147483647
    return np.array(values)


# NIST SP 1065, table 31 (seven digits); the other sizes computed with extended precision.
NBS14_OVERLAPPED = {
    1: 0.29223187810675916,
    2: 0.2010160421709385,
    5: 0.13318637457744736,
    10: 0.09159953420118654,
    50: 0.039501786819481584,
    100: 0.03241343026056983,
    333: 0.008244123626136668,
    499: 0.0028325053644187104,
}
NBS14_DISJOINT = {
    1: 0.29223187810675916,
    2: 0.2051016155948553,
    5: 0.1359566229954979,
    10: 0.09965736063174786,
    50: 0.043270981191617854,
    100: 0.038978043308026525,
    333: 0.00271619077347962,
    499: 0.002624044593093992,
}
NBS14_PRINTED = {1: 2.922319e-01, 10: 9.159953e-02, 100: 3.241343e-02}

# NIST SP 1065, table 30: nine frequencies.
NINE_POINTS = [892, 809, 823, 798, 671, 644, 883, 903, 677]

# Expected Allan variances at tau0 = 0.01 s, by cluster size; from the closed forms with 40 digits.
SIZES = [1, 2, 7, 100, 10000]
AVAR = {
    ("quantization", 1e-3): [0.03, 0.0075, 0.0006122448979591836, 3e-06, 3e-10],
    ("random_walk", 0.005): [0.0025, 0.00125, 0.00035714285714285714, 2.5e-05, 2.5e-07],
    ("bias_instability", 0.0028): [
        4.991099015361839e-06,
        3.992879212289469e-06,
        3.5266691032102584e-06,
        3.4601437092490105e-06,
        3.45956631123999289e-6,
    ],
    ("rate_random_walk", 1e-4): [5e-11, 7.5e-11, 2.3571428571428573e-10, 3.3335e-09, 3.33333335e-07],
    ("rate_ramp", 1e-6): [5e-17, 2e-16, 2.4500000000000004e-15, 5e-13, 5e-09],
}
RATE_RANDOM_WALK_AVERAGED = [
    3.3333333333333335e-11,
    6.666666666666667e-11,
    2.3333333333333335e-10,
    3.3333333333333334e-09,
    3.333333333333334e-07,
]
GAUSS_MARKOV_SAMPLED = [  # sigma 1e-3, correlation time 10 s; mpmath, 50 digits
    9.9950016662500833e-10,
    1.4980017488339705e-9,
    4.6898651595073285e-9,
    6.18952347612069967e-8,
    1.70001835143093896e-7,
]
GAUSS_MARKOV_AVERAGED = [
    6.6616689991669126e-10,
    1.3313351986674536e-9,
    4.6422465003294381e-9,
    6.18919065856433987e-8,
    1.70001815976578963e-7,
]
SINUSOID = [  # amplitude 1e-3, 0.37 Hz
    1.351087990165597e-10,
    5.402891708309786e-10,
    6.591762353864713e-09,
    5.250766368933746e-07,
    0.0,
]
FILTERS = {  # ten digits
    ("first_order", "σ = 0.05"): [0.002120410495, 0.001313891963, 0.0004527064906, 3.379255146e-05, 3.394926653e-07],
    ("butterworth2", "N = 0.005"): [0.001135520778, 0.001001415634, 0.0003444209893, 2.534229398e-05, 2.54341456e-07],
    ("brick_wall", "N = 0.005"): [0.0007431732714, 0.001095121563, 0.000338100862, 2.491328365e-05, 2.499913275e-07],
}
# Discrete flicker noise, B = 1, by cluster size.
FLICKER = {
    1: 0.6366197723675814,
    2: 0.5092958178940651,
    3: 0.4767350182491623,
    4: 0.4633353894394225,
    8: 0.4480724856312219,
    16: 0.4432942376407003,
    100: 0.44134486087359776,
}
FLICKER_LIMIT = 0.4412712003053032
# Eq. (19) with B = 1, by f0·T; mpmath, 40 digits.
CUTOFF = {
    0.01: 0.0003140559315019742,
    0.1: 0.03040251621449701,
    0.5: 0.3735260753157165,
    1: 0.4308026103716996,
    2: 0.4383757987608476,
    5: 0.44079102844776,
    20: 0.4412409788330158,
}
# Q 1.63, N 1, B 0.188, K 0.0125 at tau0 = 1 s, m = 1, 10, 100.
MIXTURE = {"quantization": 1.63, "random_walk": 1.0, "bias_instability": 0.188, "rate_random_walk": 0.0125}
MIXTURE_AVAR = {1: 8.993278814234559, 10: 0.19598996628862178, 100: 0.03160455651271644}

# Equivalent degrees of freedom at 1000 samples, by cluster size; exact sums with 40 digits.
EDF_SIZES = [1, 2, 10, 100, 333, 499]
EDF = {
    "quantization": [514.0360545969611, 513.2723830287731, 507.1731225296443, 440.2065180102916, 333.231606730452, 3.0],
    "random_walk": [
        666.2222963951936,
        570.2045030833214,
        146.0723257314158,
        12.813267782600164,
        2.6772507268484245,
        1.0053605555705096,
    ],
    "bias_instability": [
        809.9231886971629,
        591.5347484880655,
        116.39222419688984,
        9.925601492610287,
        1.8324758496335547,
        1.0000843437495888,
    ],
    "rate_random_walk": [
        999.0,
        513.0074834418098,
        91.75477375281,
        7.757153217468789,
        1.4069539594532092,
        1.0000160481766733,
    ],
}
# Covariance of the Allan variances of MIXTURE at 1000 samples, m = 1, 10, 100.
MIXTURE_COVARIANCE = [
    [0.30450618033361493, 0.0016306529023233335, 1.6340276333352965e-05],
    [0.0016306529023233335, 0.0002727642295393753, 6.810532983437638e-06],
    [1.6340276333352965e-05, 6.810532983437638e-06, 0.0001667685702885789],
]

# The paper's printed values and errors (Tables II and IV): value, ±, samples in the record, cluster size of eq. (26), and
# whether δ was rounded to 0.1 % before it was multiplied. No single rule of rounding gives all cells.
PLUS_MINUS = {
    "CIMU gyro X quantization": (0.973, 0.074, 1_440_000, 16384, True, 3),
    "CIMU gyro Y quantization": (0.517, 0.020, 1_440_000, 4096, True, 3),
    "CIMU gyro Z quantization": (0.577, 0.016, 1_440_000, 2048, True, 3),
    "CIMU accel X quantization": (1.680, 0.128, 1_440_000, 16384, True, 3),
    "CIMU accel Y quantization": (1.298, 0.099, 1_440_000, 16384, True, 3),
    "CIMU gyro X random walk": (0.0015, 0.0005, 1_440_000, 262144, False, 4),
    "CIMU gyro Y random walk": (0.0019, 0.0006, 1_440_000, 262144, False, 4),
    "CIMU gyro Z random walk": (0.0018, 0.0006, 1_440_000, 262144, False, 4),
    "CIMU accel X ramp": (2.64, 0.88, 1_440_000, 262144, False, 2),
    "CIMU accel Y ramp": (0.89, 0.30, 1_440_000, 262144, False, 2),
    "HG1700 gyro X quantization": (5.1154, 0.068, 720_000, 256, False, 3),
    "HG1700 accel X quantization": (2.119, 0.067, 720_000, 1448, False, 3),
    "HG1700 accel Y quantization": (2.199, 0.118, 720_000, 4096, False, 3),
    "HG1700 accel Z quantization": (2.185, 0.058, 720_000, 1024, False, 3),
    "HG1700 accel X rate random walk": (0.76, 0.25, 720_000, 131072, False, 2),
    "HG1700 accel Y rate random walk": (1.16, 0.39, 720_000, 131072, False, 2),
    "HG1700 accel Z rate random walk": (3.35, 1.12, 720_000, 131072, False, 2),
}


def interruptible():
    """Make a child process interruptible: children of a background process would ignore an interruption."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)

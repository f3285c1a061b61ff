"""Every constant and printed result of the paper, each with its place. No other module repeats one.

Y.-B. Jia, M. T. Mason, M. A. Erdmann, "A State Transition Diagram for Simultaneous Collisions with
Application in Billiard Shooting", 2008. Numbers the paper only shows as a curve carry the name REFERENCE: two
programs that share no code with this one agree on them. Misprints are listed in ``impact/MODEL.md``.
"""

from dataclasses import dataclass
from math import atan, cos, hypot, sin, sqrt

from impact import Ball, Contact, Cue, CueShot, TwoBallDrop

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A mean with the standard deviation of single measurements and their number."""

    mean: float
    sd: float
    count: int


# Section 2.3 and Fig. 3: the ellipse (15), by the formulas of the text
def printed_ellipse(drop: TwoBallDrop) -> dict[str, float]:
    """Evaluate what Section 2.3 and its footnote 3 say of the bounding ellipse; angles in rad, the rest N s.

    The printed centre turns out to be meant along the axes of the ellipse, which are turned by θ.
    """
    first, second, velocity = drop.upper.mass, drop.lower.mass, drop.approach_velocity
    angle = atan(-2 * first / second) / 2
    along = -velocity * cos(angle) / (cos(angle) ** 2 / first + (1 - sin(2 * angle)) / second)
    across = velocity * sin(angle) / (sin(angle) ** 2 / first + (1 + sin(2 * angle)) / second)
    reach = sqrt(first * second)
    return {
        "axis angle θ [rad]": angle,
        "centre along the axis [N s]": along,
        "centre across it [N s]": across,
        "centre from the origin [N s]": hypot(along, across),
        "right end, I1 [N s]": -2 * first * velocity,
        "right end, I2 [N s]": -2 * first * velocity,
        "top, I2 [N s] (footnote 3)": (first + reach) * -velocity,
        "top, I1 [N s] (footnote 3)": -first * velocity,
        "bottom, I2 [N s] (footnote 3)": (first - reach) * -velocity,
        "bottom, I1 [N s] (footnote 3)": -first * velocity,
    }


# Section 2.3 and Fig. 4: one collision followed through its states
FIG4_DROP = TwoBallDrop(
    upper=Ball(mass=1.0, radius=0.1),  # the radius plays no part
    lower=Ball(mass=1.0, radius=0.1),
    ball_ball=Contact(restitution=sqrt(0.9), stiffness=1.0),
    ball_table=Contact(restitution=sqrt(0.4), stiffness=10.0),
    approach_velocity=-3.0,
)
FIG4_STATES = ("S1", "S3", "S1", "S2")  # Section 2.3, fourth paragraph after Fig. 4
FIG4_FIRST_EVENTS = "C2-C1-R2"  # Fig. 4(b), first row
FIG4_ENERGY_LOSS = 1.2494  # J, Section 2.3
FIG4_REFERENCE_IMPULSES = (  # N s, (I1, I2) at the end of each state; dots in Fig. 4(a)
    (3.608797, 3.966122),
    (3.966122, 3.966122),
    (5.441360, 5.320215),
    (5.441360, 6.176912),
)
FIG4_REFERENCE_VELOCITIES = (2.4413596, 0.7355524)  # m/s, upper and lower ball
POISSON_REQUIRED_IMPULSE = 5.906  # N s, I1 that Poisson's law would ask for, end of Section 2.3
POISSON_ELASTIC_ENERGY = -1.01  # J, E1 there

# Section 2.4 and Fig. 5: two ping-pong balls on plexiglass
BALL_MASS = 0.00023  # kg as printed; a ping-pong ball has 0.0027 (no matter for the impact, by Theorem 4)
BALL_RADIUS = 0.019  # m
BALL_TABLE = Measured(mean=0.846529, sd=0.020827, count=16)  # e2: drops from different heights, four balls
BALL_BALL = Measured(mean=0.807755, sd=0.021231, count=8)  # e1: eight heights, highest rebound of each
STIFFNESS_RATIO = 10.0  # k2/k1, "guess", caption of Fig. 5
COLLISION_TRIALS = 10  # drop heights, the trial with the highest rebounds of each
APPROACH_VELOCITIES = (-2.0, -4.0)  # m/s, ends of the lines in Fig. 5
FIG5_DROP = TwoBallDrop(
    upper=Ball(mass=BALL_MASS, radius=BALL_RADIUS),
    lower=Ball(mass=BALL_MASS, radius=BALL_RADIUS),
    ball_ball=Contact(restitution=BALL_BALL.mean, stiffness=1.0),
    ball_table=Contact(restitution=BALL_TABLE.mean, stiffness=STIFFNESS_RATIO),
    approach_velocity=-1.0,  # the lines of Fig. 5 are straight (Theorem 4)
)
FIG5_REFERENCE_SLOPES = (0.7793977, 0.1866439)  # v1/|v0| and v2/|v0|: the lines of Fig. 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """One row of Table 1: contact normal, cue velocity, printed ball velocity and angular velocity (SI)."""

    normal: Vector
    cue_velocity: Vector
    velocity: Vector
    angular_velocity: Vector


# Section 3.2, Table 1
SHOT_BALL_MASS = 0.1673  # kg
SHOT_CUE_MASS = 0.5018  # kg
SHOT_BALL_RADIUS = 0.0286  # m
SHOT_TABLE_FRICTION = 0.152479
SHOT_TIP_FRICTION = 0.4
SHOT_TIP_RESTITUTION = 0.656532
SHOT_TABLE_RESTITUTION = 0.51625
SHOT_STIFFNESS_RATIO = 1 / 1.5  # k_bt/k_cb; Table 1 prints the inverse, k_cb/k_bt = 1.5
SHOTS = {
    "vertical": Shot(
        normal=(-1 / sqrt(6), -2 / sqrt(6), 1 / sqrt(6)),
        cue_velocity=(0.0, 0.0, -2.0),
        velocity=(0.3963, 0.7926, 0.4506),
        angular_velocity=(27.97, -13.98, 0.0),
    ),
    "horizontal": Shot(
        normal=(-sqrt(2) / 2, -sqrt(2) / 2, 0.0),
        cue_velocity=(0.8, 0.0, 0.0),
        velocity=(0.6299, 0.4614, 0.0),
        angular_velocity=(0.0, 0.0, 10.42),
    ),
    "jump": Shot(
        normal=(-sqrt(2) / 2, 0.0, sqrt(2) / 2),  # z is printed negative, which gives no impact at all
        cue_velocity=(1.0, 0.0, -1.0),
        velocity=(1.169, 0.0, 0.1883),
        angular_velocity=(0.0, 13.15, 0.0),
    ),
    "masse": Shot(
        normal=(-2 / sqrt(149), -1 / sqrt(149), 12 / sqrt(149)),
        cue_velocity=(4.0, 0.0, -16.0),
        velocity=(-0.3253, 0.2938, 6.232),
        angular_velocity=(-88.48, 179.8, -3.178),
    ),
}
SHOT_BALL = Ball(mass=SHOT_BALL_MASS, radius=SHOT_BALL_RADIUS)


def cue_shot(shot: Shot, stiffness_ratio: float = SHOT_STIFFNESS_RATIO) -> CueShot:
    """Set up a shot of Table 1 with its constants and a ratio k_bt/k_cb."""
    return CueShot(
        ball=SHOT_BALL,
        cue=Cue(mass=SHOT_CUE_MASS),
        normal=shot.normal,
        cue_velocity=shot.cue_velocity,
        tip_ball=Contact(restitution=SHOT_TIP_RESTITUTION, friction=SHOT_TIP_FRICTION),
        ball_table=Contact(
            restitution=SHOT_TABLE_RESTITUTION, friction=SHOT_TABLE_FRICTION, stiffness=stiffness_ratio
        ),
    )

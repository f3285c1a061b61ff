"""The sentences a fit may print as notes, in one place, so that each can be explained: see NOTES.md."""

from enum import StrEnum


class Note(StrEnum):
    """Templates of the notes, for `str.format`.

    Examples
    --------
    >>> Note.NO_OWN_DROPS.format(drops="drops on the plate", contact="ball-table")
    'no drops on the plate: ball-table restitution has no measurement of its own'
    """

    NO_OWN_DROPS = "no {drops}: {contact} restitution has no measurement of its own"
    NO_TWO_BALL_TRIALS = "no two-ball trials: the stiffness ratio cannot be fitted"
    LEFT_OUT = "{count} {status} of {all} trials left out"
    NONE_USABLE = (
        "none of the {count} {trials} is usable ({names}): look at their overlays, mend what their reasons "
        "name, and run process again with --resume"
    )
    EXACT = "standard deviations of zero are taken as not stated: {count} of them"
    COPIED = "{trials} digit for digit: a row that was only copied makes the intervals too narrow"
    OUTLIER = "{trial} stands apart from the other {trials} and was left out"
    TOO_FEW = "too few {trials} to see their scatter: {scatter} assumed"
    TOO_ALIKE = "the {trials} agree better than trials can: taken to scatter at least as much as they state"
    DEPENDS_ON_SPEED = "restitution of the {trials} {law}; the fit takes one value for all speeds"
    MISFIT = (
        "the model misses the measurements by more than their scatter (probability {chance}):"
        " do not trust the intervals"
    )
    AT_BOUND = (
        "the best fit has the {name} at its bound, {bound}: look for an error in what was measured, or"
        " take it as a bound on one side"
    )
    ONE_MASS_PAIR = (
        "the two-ball trials fitted have one mass ratio, and drop heights carry no information on the"
        " stiffness ratio: trials with a second mass pair would"
    )
    SHOT_LEFT_OUT = "{trial} left out: {reason}"
    SHOT_NOT_AIMED = "{column} ({meaning}) is missing in {shots} and taken as 0: add a column of that name"
    SHOT_UNSTATED = "velocities without a standard deviation above zero: {share} of speed assumed"
    SHOTS_TOO_FEW = "as few numbers measured as parameters fitted: fix some, or add shots"
    SHOTS_MISFIT = (
        "the model misses the shots by more than they state (probability {chance}); the intervals"
        " are widened accordingly"
    )
    SHOTS_UNDETERMINED = (
        "{names} cannot be told from these shots: add shots with a raised cue and with"
        " different contact points, or fix it"
    )

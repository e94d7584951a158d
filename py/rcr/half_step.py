"""The half step between velocities and positions of YADE's leapfrog, at the start of a motion."""

from yade.minieigenHP import Vector3
from yade.wrapper import NewtonIntegrator, Omega

O = Omega()


def half_step_start():
    """Let the velocities of now count as those of this moment: the error of a smooth motion then falls with dt², without it with dt.

    YADE's leapfrog holds velocities half a step before positions. What a script sets, rest for example, it takes as the velocities of half
    a step ago, and moves a body that starts from rest under the acceleration a by a t dt/2 too far. Here half a step of gravity and of
    permanent forces (``O.forces.setPermF``, ``setPermT``) is taken from the velocities, which the first step gives back; contact forces of that step
    are the half, too. So velocities that a script reads stay half a step behind.

    Call it once, when bodies, gravity, permanent forces and ``O.dt`` are set, and again after a change of ``O.dt`` or of velocities in a
    motion that was stopped. It does nothing for impacts, whose times are known to a step, nor for springs that are loaded already.

    Raises
    ------
    ValueError
        If the scene has no NewtonIntegrator, or ``O.dt`` is not positive.
    """
    integrators = [engine for engine in O.engines if isinstance(engine, NewtonIntegrator) and not engine.dead]
    if len(integrators) != 1:
        raise ValueError(f"O.engines has {len(integrators)} NewtonIntegrators that are not dead; wanted one, whose gravity acts")
    if not 0 < O.dt < float("inf"):
        raise ValueError(f"O.dt = {O.dt}; wanted the time step of the scene > 0 [s]")
    half, gravity = 0.5 * O.dt, integrators[0].gravity
    loaded = O.forces.getPermForceUsed()
    if loaded:
        O.forces.f(0, True)  # else permF tells nothing of what was set just now; without such forces YADE would read where none are
    for body in O.bodies:
        state = body.state
        if body.isClumpMember or state.blockedDOFs == "xyzXYZ":
            continue
        force, torque = (O.forces.permF(body.id), O.forces.permT(body.id)) if loaded else (Vector3.Zero, Vector3.Zero)
        state.vel -= half * _of_free(state, "xyz", gravity + force / state.mass)
        state.angVel -= half * _of_free(state, "XYZ", Vector3(*(torque[k] / state.inertia[k] for k in range(3))))


def _of_free(state, names, vector):
    """The components along the degrees of freedom that are not blocked."""
    return Vector3(*(0 if name in state.blockedDOFs else component for name, component in zip(names, vector)))

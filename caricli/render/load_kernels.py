"""The kernels of the pictures, ready to be launched."""

from types import ModuleType

from caricli.io.start_warp import start_warp


def load_kernels() -> ModuleType:
    """Start warp once per process; returns the module of kernels (`caricli.render.kernels`)."""
    start_warp()
    from caricli.render import kernels

    return kernels

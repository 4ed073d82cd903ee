import numpy as np
import pytest

from caricli.methods.evaluate.portrait_studio import PortraitStudio

SIZE = 128


@pytest.fixture(scope="module")
def studio(head_template):
    return PortraitStudio(head_template, SIZE)


@pytest.fixture(scope="module")
def portrait(studio, strangers):
    return studio.portray("someone", strangers[1], np.random.default_rng(4))

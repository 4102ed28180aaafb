"""Types of the rows of a structured array, and of what makes one."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.void]
Change = Callable[..., Rows]

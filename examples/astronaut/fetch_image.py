"""Write the picture of this example: NASA's public-domain portrait of Eileen Collins, out of the scikit-image package.

python examples/astronaut/fetch_image.py examples/astronaut/astronaut.png
"""

import sys

from PIL import Image
from skimage import data

Image.fromarray(data.astronaut()).save(sys.argv[1], "PNG")

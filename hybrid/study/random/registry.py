"""All families of random scenes by name, in the order of the tables."""

from hybrid.study.random import clay, pressing, rides, slab, tumbling

FAMILIES = {**rides.FAMILIES, **slab.FAMILIES, **pressing.FAMILIES, **clay.FAMILIES, **tumbling.FAMILIES}

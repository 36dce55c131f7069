"""All problems of the study of precision, by name, in the order of the panels of its figures."""

from hybrid.study.precision.problems import anchor, cantilever, column, footing, manufactured, platen, sphere, tumbling

PROBLEMS = {
    "column": column.PROBLEM,
    "manufactured": manufactured.PROBLEM,
    "cantilever": cantilever.PROBLEM,
    "sphere": sphere.PROBLEM,
    "platen": platen.PROBLEM,
    "tumbling": tumbling.PROBLEM,
    "footing": footing.PROBLEM,
    "anchor": anchor.PROBLEM,
}

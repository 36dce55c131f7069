"""One known way to fail each: a small scene that drives a parameter through it (`hybrid.study.cases`)."""

"""Known ways in which runs fail: each is driven through by a parameter, with the plain method and with remedies."""

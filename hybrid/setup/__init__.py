"""From a Scene to a model and its first state: the only readers of scenes, apart from what observers print."""

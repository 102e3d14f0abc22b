def scene(user):
    yield 0.1

"""Sets that grow together."""


class Sets:
    """Union-find; anything that can be a key may be a member, and is from when it is first named."""

    def __init__(self):
        self.up = {}

    def root(self, x):
        self.up.setdefault(x, x)
        while self.up[x] != x:
            self.up[x] = self.up[self.up[x]]
            x = self.up[x]
        return x

    def join(self, x, y):
        self.up[self.root(x)] = self.root(y)

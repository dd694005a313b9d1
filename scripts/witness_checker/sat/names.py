"""Names of layers, which nothing depends on: chosen so that as many gluings as possible are known.

The layers of a cell (or of a shell, a thin one along its border) may be numbered in any order. If the cell outside of a
region has its names, those inside can be named after the layers outside that they go on from, the one that begins
last: then the gluing is known (`given`). If the cell inside has its names, those outside can be sorted by the ones they
go on into (`sorted`). Every cell is named once, through one region, and other regions are `free`. Cells with no
layer, or one, have their names from the start.
"""


def name_layers(regions, layers):
    """regions: {region: (cell outside, cell inside)}; layers: {cell: number}. What is known of each region."""
    kinds = dict.fromkeys(regions, "free")
    beside = {}
    for region, cells in regions.items():
        for cell in cells:
            beside.setdefault(cell, []).append(region)
    cells = sorted(beside, key=lambda x: layers[x])
    named = set()

    def spread(stack):
        named.update(stack)
        while stack:
            cell = stack.pop(0)
            for region in beside[cell]:
                outer, inner = regions[region]
                if outer not in named or inner not in named:
                    kinds[region] = "given" if outer == cell else "sorted"
                    named.add(inner if outer == cell else outer)
                    stack.append(inner if outer == cell else outer)

    spread([x for x in cells if layers[x] <= 1])
    for root in cells:
        if root not in named:
            spread([root])
    return kinds

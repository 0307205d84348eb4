!!VP2.0
# Irregular z-buffer, raster phase: test one triangle against the samples of one logical cell.
# [Johnson04] sec. 5 and 5.1: walk the cell's list, three edge tests, interpolate z, emit a framebuffer fragment.
#
# A task is one grid fragment that passed the stencil test, so its list is not empty.
#   v[0]  tile column / tiles in a row, tile row / tiles in a column, 0, cell within its tile / tile area
#   v[1] v[2] v[3]  edge functions (a, b, 0, c): inside where a x + b y + c >= 0, x and y in logical cells
#   v[4]  depth of the triangle's plane (a, b, 0, c), as in izb_build.s
#   v[5]  logical row / physical width, logical column / physical height
#   c[0]  1 / tiles in a row, 1 / tiles in a column
#   c[1]  cells in a row of tiles, cells of the physical grid, 0, tile area
#   B1    list heads and list nodes, as in izb_build.s
# Emits (node index of the sample, depth of the triangle there).
#
# R0 head index, then node index   R1 node (x, y, depth, next)   R2 edge functions, depth

main:   FLR  R0, v[5];                          # physical tile: hash of the logical tile
        MAD  R0, R0, c[0], v[0];
        FRC  R0, R0;
        DP4  R0.x, R0, c[1];
        LD   R0.x, [B1 | R0.x];

node:   LD   R1, [B1 | R0.x];
        DPHC R2.x, R1, v[1];
        DPHC R2.y, R1, v[2];
        DPHC R2.z, R1, v[3];
        BRA  next (LT.xyzz);
        DPH  R2.w, R1, v[4];
        EMIT R0.x, R2.w;
next:   MOVC R0.x, R1.w;
        BRA  node (NE.x);
END

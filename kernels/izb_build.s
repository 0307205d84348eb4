!!VP2.0
# Irregular z-buffer, build phase: put the eye-view samples of one pixel tile into the grid of lists.
# [Johnson04] sec. 5 and 6: pixels in pairs, list update under the physical cell's lock, stencil marked.
#
# A task is one tile of pixels; depths and list nodes are stored row by row of the image, or in another order.
#   v[0]  -(pairs in the tile), node index of its first pixel, the same + 1, index of its first depth pair
#   v[1]  x and y of its first pixel
#   c[0]  1: what marks a cell in the stencil
#   c[1]  light-space step of one pixel in x        light space: (X, Y, Z, W), X and Y in logical cells times W,
#   c[2]  light-space step of one pixel in y        Z = W - (light depth of the nearest sample) / (eye depth)
#   c[3]  light-space step of reciprocal eye depth  so that depth = Z / W is 0 at the nearest sample, 1 far away
#   c[4]  cells in a row of the logical grid
#   c[5]  1 / physical width, 1 / physical height, twice
#   c[6]  tile width, tile height, twice             (of the physical grid's tiles)
#   c[7]  tiles in a row, tiles in a column, twice
#   c[8]  tile area - tile width, tiles in a row * tile area - tile area, twice
#   c[9]  tile width, tile area, twice
#   c[133 + k]  steps of v[0] from pair k = -pairs ... -1 to the next one
#   c[255 + k]  light-space position of pair k relative to the tile's first pixel, plus the image origin's
#   B0    stencil (one word a logical cell, at index 0) and depths (two words a pair)
#   B1    list heads (one word a physical cell, at index 0) and list nodes (four words: x, y, depth, next)
# Pixels without a sample have depth NaN: they land in the guard elements of both windows, not in any cell.
#
# R0 pair counter, node indices, depth index   R1, R2 the two nodes   R3 depths, reciprocals, stencil indices
# R4 logical cells, then physical position     R5 tile parts, then head indices (also the lock numbers)

main:   MOV  R0, v[0];

pair:   ARL  A0.x, R0.x;
        MUL  R1, v[1].x, c[1];                  # position in light space without depth
        MAD  R1, v[1].y, c[2], R1;
        ADD  R1, R1, c[A0.x + 255];
        ADD  R2, R1, c[1];
        LD   R3.xy, [B0 | R0.w];                # reciprocal eye depths
        MAD  R1, R3.x, c[3], R1;
        MAD  R2, R3.y, c[3], R2;
        RCP  R3.x, R1.w;
        RCP  R3.y, R2.w;
        MUL  R1, R1, R3.x;                      # x, y in logical cells, depth
        MUL  R2, R2, R3.y;

        FLR  R4.xy, R1;                         # logical cells i, j of both pixels
        FLR  R4.zw, R2.xyxy;
        MAD  R3.xy, R4.ywyw, c[4].x, R4.xzxz;   # stencil index
        MUL  R5, R4.yxwz, c[5];                 # physical cell: (i + floor(j / width) * tile) mod width ...
        FLR  R5, R5;
        MAD  R4, R5, c[6], R4;
        MUL  R4, R4, c[5];
        FRC  R4, R4;
        MUL  R4, R4, c[7];                      # ... in tiles; head index of a tiled grid
        FLR  R5, R4;
        MUL  R5, R5, c[8];
        MAD  R5, R4, c[9], R5;
        ADD  R5.xy, R5.xzxz, R5.ywyw;

        LOCK R5.x;                              # prepend the first pixel
        LD   R1.w, [B1 | R5.x];
        ST   [B1 | R5.x].x, R0.y;
        UNLK R5.x;
        ST   [B1 | R0.y], R1;

        LOCK R5.y;                              # prepend the second pixel
        LD   R2.w, [B1 | R5.y];
        ST   [B1 | R5.y].x, R0.z;
        UNLK R5.y;
        ST   [B1 | R0.z], R2;

        ST   [B0 | R3.x].x, c[0].x;             # mark both logical cells
        ST   [B0 | R3.y].x, c[0].x;
        ADDC R0, R0, c[A0.x + 133];
        BRA  pair (LT.x);
END

!!VP2.0
# Hierarchical shadow volumes, Stage 1: take one triangle into the classification of one block of 2 x 2 tiles.
# [Aila04] appendix A and sec. 5.1: boundary tiles, and one stencil value at the corner that the four tiles share.
#
# A task is one block that a shadow-volume triangle meets, as the low-resolution rasterizer and the early occlusion
# test hand it over (both are fixed-function units in front of the stage, [Aila04] figure 3).
#   v[0]  entry of the block in its PSV buffer, -, its lock, stencil operation at the sample: 1, -1, 0 if not covered
#   v[1]  the four tiles, column by column: 1 where the triangle cuts the tile's box, -1 where all its pixels pass the
#         depth test, 0 where it counts for nothing
#   c[0]  0, 1, 1/2
#   c[1]  1/2, 1/4, 1/8, 1/16: what brings the bit of each tile behind the point
#   c[2]  1, 2, 4, 8: bits of boundary tiles
#   B0    PSV buffers: two words an entry, the stencil value and the bits of the four tiles
# Tiles share a value, but a triangle may count in some of them only: the others become boundary tiles then.
#
# R0 stencil operation   R1 tiles that become boundary tiles   R2 entry   R3 bits, unpacked

main:   SLT  R1, v[1], c[0].x;
        MULC R3, R1, v[0].w;
        BRA  sample (NE.xyzw);                  # it counts, and the sample is inside
        SGTC R1, v[1], c[0].x;
        BRA  change (NE.xyzw);                  # it cuts a tile
        RET;
sample: SUB  R1, c[0].y, R1;
        MOV  R0.x, v[0].w;

change: LOCK v[0].z;
        LD   R2.xy, [B0 | v[0].x];
        ADD  R2.x, R2.x, R0.x;
        MUL  R3, R2.y, c[1];
        FRC  R3, R3;
        SGE  R3, R3, c[0].z;                    # boundary tiles until now
        SLT  R3, R3, R1;
        DP4  R3.x, R3, c[2];
        ADD  R2.y, R2.y, R3.x;
        ST   [B0 | v[0].x].xy, R2;
        UNLK v[0].z;
END

!!VP2.0
# Hierarchical shadow volumes, Stage 2: update the low-resolution stencil buffer of one block of 2 x 2 tiles for one
# triangle, and hand on the tiles that have to be drawn pixel by pixel. [Aila04] appendix A, optimized architecture.
#
# A task is one block that a shadow-volume triangle meets, as for Stage 1 (hsv_stage1.s), when its volume is classified.
#   v[0]  entry of the block in its PSV buffer, its element Smin + Smax, its lock, -
#   v[1]  the four tiles: not 0 where the triangle would have to be drawn
#   v[2]  their numbers
#   c[0]  0, 1, 1/2, 2
#   c[1]  1/2, 1/4, 1/8, 1/16 and
#   c[3]  1/32, 1/64, 1/128, 1/256: what brings a tile's boundary bit and its other bit behind the point
#   c[4]  16, 32, 64, 128: bits of tiles met before in this volume; the paper's `first` is set where they are not
#   B0    PSV buffers: two words an entry, the stencil value and the bits of the four tiles
#   B1    low-resolution stencil: four words Smin + Smax (0 lit, 1 mixed, 2 in shadow), then four words FS, a block
# Emits (number of a tile, 1). Drawing it brings its Smin and Smax up to date.
#
# R0 FS element   R1 tiles met   R2 PSV entry   R3, R6 work   R4 FS   R5 tiles to be drawn

main:   MUL  R1, v[1], v[1];
        ADD  R0.x, v[0].y, c[0].y;
        LOCK v[0].z;
        LD   R2.xy, [B0 | v[0].x];
        LD   R4, [B1 | R0.x];
        MUL  R3, R2.y, c[3];
        FRC  R3, R3;
        SGE  R3, R3, c[0].z;
        SLTC R3, R3, R1;                        # tiles met for the first time in this volume
        BRA  first (NE.xyzw);

known:  MUL  R5, R2.y, c[1];
        FRC  R5, R5;
        SGE  R5, R5, c[0].z;                    # boundary tiles
        SGT  R6, R1, R4;                        # tiles met that were not in shadow before this volume
        MUL  R5, R5, R6;
        SUB  R6, R6, R5;                        # those that are lit or in shadow as a whole
        SGT  R3.x, R2.x, c[0].x;
        MULC R6, R6, R3.x;
        BRA  shade (NE.xyzw);

draw:   UNLK v[0].z;
        MOVC R5, R5;
        BRA  skip0 (EQ.x);
        EMIT v[2].x, R5.x;
skip0:  BRA  skip1 (EQ.y);
        EMIT v[2].y, R5.y;
skip1:  BRA  skip2 (EQ.z);
        EMIT v[2].z, R5.z;
skip2:  BRA  skip3 (EQ.w);
        EMIT v[2].w, R5.w;
skip3:  RET;

first:  LD   R6, [B1 | v[0].y];
        SGE  R6, R6, c[0].w;                    # in shadow before this volume
        SUB  R6, R6, R4;
        MAD  R4, R3, R6, R4;
        ST   [B1 | R0.x], R4;
        DP4  R3.x, R3, c[4];
        ADD  R2.y, R2.y, R3.x;
        ST   [B0 | v[0].x].xy, R2;
        BRA  known;

shade:  MAX  R4, R4, R6;
        ST   [B1 | R0.x], R4;
        LD   R3, [B1 | v[0].y];
        MUL  R6, R6, c[0].w;
        MAX  R3, R3, R6;                        # Smin = Smax = shadow
        ST   [B1 | v[0].y], R3;
        BRA  draw;
END

!!VP2.0
# Irregular z-buffer, raster phase: test one triangle against the samples of one logical cell, kept in a k-d tree.
# [Johnson04] sec. 2: at each step, the area of a subtree is tested against that of the triangle.
#
# Task, attributes and constants as in izb_raster.s, and
#   v[6]  bounds of the triangle: least x and y, greatest x and y
#   c[2]  4, 3: words of a node, place of its right child
#   B1    roots and tree nodes, as in izb_build_kd.s
# Emits (node index of the sample, depth of the triangle there).
#
# R0 node index   R1 node (x, y, left, right)   R2 edge functions, depth   R3 tests

main:    FLR  R0, v[5];                         # as in izb_raster.s
         MAD  R0, R0, c[0], v[0];
         FRC  R0, R0;
         DP4  R0.x, R0, c[1];
         LD   R0.x, [B1 | R0.x];

node:    LD   R1, [B1 | R0.x];
         DPHC R2.x, |R1|, v[1];
         DPHC R2.y, |R1|, v[2];
         DPHC R2.z, |R1|, v[3];
         BRA  smaller (LT.xyzz);
         DPH  R2.w, |R1|, v[4];
         EMIT R0.x, R2.w;

smaller: MOVC R3.xy, R1.zxxx;                   # left child, axis
         BRA  larger (EQ.x);
         BRA  small_y (LT.y);
         ADDC R3.z, v[6].x, -R1.x;
         BRA  larger (GE.z);
         BRA  go_left;
small_y: ADDC R3.z, v[6].y, -R1.y;
         BRA  larger (GE.z);
go_left: MOV  R0.x, R1.z;
         BRA  node;

larger:  MOVC R3.xy, R1.wxxx;                   # right child or way on, axis
         BRA  up (LE.x);
         BRA  large_y (LT.y);
         ADDC R3.z, v[6].z, -R1.x;
         BRA  go_right (GE.z);
         BRA  skip;
large_y: ADDC R3.z, v[6].w, -R1.y;
         BRA  go_right (GE.z);
skip:    MAD  R3.z, R1.w, c[2].x, c[2].y;       # the way on is at the right end of the subtree
         LD   R1.w, [B1 | R3.z];
         MOVC R3.x, R1.w;
         BRA  skip (GT.x);
up:      MOVC R0.x, -R1.w;
         RET  (EQ.x);
         LD   R1, [B1 | R0.x];
         BRA  larger;
go_right: MOV R0.x, R1.w;
         BRA  node;
END

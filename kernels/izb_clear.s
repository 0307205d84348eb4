!!VP2.0
# Irregular z-buffer, before the build phase: clear the stencil and the heads of the physical grid's cells.
# [Johnson04] sec. 6: done before construction, and left out of the paper's measurements.
#
# A task is a run of 16-byte elements of one of the two arrays.
#   v[0]  -(elements), index of the first element in its window, 0, 0 for the stencil or 1 for the heads
#   c[0]  1, 1
#   B0    stencil (at index 0)
#   B1    heads (at index 0)
#
# R0 counter and index   R1 nothing but zeros

main:    MOVC R0, v[0];
         BRA  heads (NE.w);
stencil: ST   [B0 | R0.y], R1;
         ADDC R0.xy, R0, c[0];
         BRA  stencil (LT.x);
         RET;
heads:   ST   [B1 | R0.y], R1;
         ADDC R0.xy, R0, c[0];
         BRA  heads (LT.x);
END

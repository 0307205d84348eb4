!!VP2.0
# Irregular z-buffer, build phase, with a k-d tree instead of a list in each grid cell.
# [Johnson04] sec. 2: the alternative that the authors measured. One node a sample, so storage is bounded as with lists.
#
# Task, attributes and constants as in izb_build.s, and
#   c[10]  0, 4, 2, 3: no child, words of a node, places of its left and right child
#   B1    roots (one word a physical cell, at index 0) and tree nodes (four words: x, y, left, right)
# A node splits its cell at its own x, or where x is stored negative at its own y; smaller samples lie left. `left` is 0
# for no child. `right` is a child, or minus the node to go on with after this one's subtree: the nearest ancestor whose left
# subtree it is in (0: none). So the tree is walked without a stack.
# The sample's depth takes the place of the eye depth, which nobody needs any more.
# Pixels without a sample have depth NaN: they are not inserted.
#
# R0 to R5 as in izb_build.s   R6 node index, head index, current node, child   R7 place of a child

main:    MOV  R0, v[0];

pair:    ARL  A0.x, R0.x;
         MUL  R1, v[1].x, c[1];                 # as in izb_build.s
         MAD  R1, v[1].y, c[2], R1;
         ADD  R1, R1, c[A0.x + 255];
         ADD  R2, R1, c[1];
         LD   R3.xy, [B0 | R0.w];
         MAD  R1, R3.x, c[3], R1;
         MAD  R2, R3.y, c[3], R2;
         RCP  R3.x, R1.w;
         RCP  R3.y, R2.w;
         MUL  R1, R1, R3.x;
         MUL  R2, R2, R3.y;

         FLR  R4.xy, R1;
         FLR  R4.zw, R2.xyxy;
         MAD  R3.xy, R4.ywyw, c[4].x, R4.xzxz;
         MUL  R5, R4.yxwz, c[5];
         FLR  R5, R5;
         MAD  R4, R5, c[6], R4;
         MUL  R4, R4, c[5];
         FRC  R4, R4;
         MUL  R4, R4, c[7];
         FLR  R5, R4;
         MUL  R5, R5, c[8];
         MAD  R5, R4, c[9], R5;
         ADD  R5.xy, R5.xzxz, R5.ywyw;

         ST   [B0 | R3.x].x, c[0].x;            # mark both logical cells
         ST   [B0 | R3.y].x, c[0].x;
         MOV  R3.x, R1.z;
         MOV  R3.y, R2.z;
         ST   [B0 | R0.w].xy, R3;               # depths

         MOV  R6.x, R0.y;
         MOV  R6.y, R5.x;
         MOVC R7.x, R1.x;
         CAL  insert (GT.x);
         MOV  R1, R2;
         MOV  R6.x, R0.z;
         MOV  R6.y, R5.y;
         MOVC R7.x, R1.x;
         CAL  insert (GT.x);
         ADDC R0, R0, c[A0.x + 133];
         BRA  pair (LT.x);
         RET;

insert:  MOV  R1.zw, c[10].x;                   # no children yet
         LOCK R6.y;
         LD   R6.z, [B1 | R6.y];
         MOVC R7.x, R6.z;
         BRA  visit (NE.x);
         ST   [B1 | R6.y].x, R6.x;              # the first of its cell
         BRA  place;

visit:   LD   R4, [B1 | R6.z];
         MOVC R7.x, R4.x;
         BRA  by_y (LT.x);
         MOV  R1.x, -|R1.x|;                    # a child splits along the other axis
         ADDC R7.x, |R1.x|, -R4.x;
         BRA  right (GE.x);
         BRA  left;
by_y:    MOV  R1.x, |R1.x|;
         ADDC R7.x, R1.y, -R4.y;
         BRA  right (GE.x);

left:    MOVC R6.w, R4.z;
         BRA  down (NE.w);
         MOV  R1.w, -R6.z;
         MAD  R7.x, R6.z, c[10].y, c[10].z;
         BRA  link;
right:   MOVC R6.w, R4.w;
         BRA  down (GT.w);
         MOV  R1.w, R4.w;
         MAD  R7.x, R6.z, c[10].y, c[10].w;
link:    ST   [B1 | R7.x].x, R6.x;
place:   ST   [B1 | R6.x], R1;
         UNLK R6.y;
         RET;
down:    MOV  R6.z, R6.w;
         BRA  visit;
END

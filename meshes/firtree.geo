// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Firtree: a blade root with 2 to 4 pairs of lobes in the slot of a disc, plane, symmetric
// about x = 0. Lengths in mm. Pulling the blade top upwards presses the upper flank of every lobe against the disc.
//
//   right half, two of the lobes, not to scale          blade_top
//                                                    x=0 ________
//                                                     |          |                ^ shank_height
//   neck_width / 2 = width from x = 0 to the neck     |  blade   |                v
//   neck_fillet    = concave radii of the blade       |          | ._____________ (disc top)
//   relief_angle   = how far the upper rounding       |          | |            | ^ rim_height
//                    turns before the neck fillet     |          | |            | v
//   tooth_radius   = convex radii of the disc         |         (  /            |   ^
//                                                     |          \_ \.upper_    |   |
//   flank: flat of length flank_length,               |  lobe 1     \. \ radius |   |
//     flank_angle to the x axis, between              |        flank_ \. \      |   | disc_depth
//     two roundings; the flat of the disc       ^     |         length \. \     |   | (from the
//     goes on beyond both ends                  |     |                 \. \    |   |  disc top)
//                                               |     |      lower_radius )  )  |   |
//   back of a lobe: parallel to the disc,       |     |             ____-- /    |   |
//     flank_clearance away from it; how         |     |       __---'___---'     |   |
//     steep it is follows from pitch          pitch   |      (    / groove_     |   |
//                                               |     |       \.  \. radius     |   |
//   wedge_angle = angle of the line from        |     |  lobe 2 \.  \.          |   |
//     lobe to lobe to the y axis, along         v  __ |           \.  \. disc   |   |
//     which pitch is measured                   ^     |             )  )        |   |
//                                   root_height |     |             |  |        |   |
//   root_corner = lower corners of the blade    |     |             /  |        |   |
//                                               v  __ |____________'   /        |   |
//                                                     |_slot_clearance'         |   |
//                                                     |_________________________|   v
//                                                     <---- disc_width / 2 ----->
//
// At the start the flats touch (gap zero) and the roundings curve away from the disc, so each flank
// is a flat punch with rounded ends. With lobe_gap > 0 only the flats of lobe 1 touch, those of lobe 2
// are lobe_gap away along their normal, those of lobe 3 twice that; with lobe_gap < 0 the lowest lobe
// touches and the gap grows upwards. The candidate contact surfaces are the flat and the first
// contact_angle of each rounding, and what lies opposite on the disc. The wall of the slot beside the
// neck and beside the lowest lobe is flank_clearance away from the blade too. root_height counts from
// the upper end of the lowest flat, groove_radius is also that of the corners of the slot. The blade
// is mesh side 1, the disc 7 % coarser, so the meshes do not match.
//
// With sectors > 0 the disc is a sector of one: its sides are radial, its bottom is an arc, the bore,
// and disc_width has no meaning. The axis of the disc is at (0, -pitch_radius); the middle of the
// flanks of lobe 1, at y = 0, is as far from it.
//
// Element size: edge_size along the contact edges (from edge_zone before to edge_zone behind the
// points where flat and rounding meet), flank_size on the rest of the candidate contact surfaces, and
// from there growing by `growth` per distance. The left half of the mesh mirrors the right half.
//
// Groups: blade, disc; blade_top, disc_bottom, disc_side_left, disc_side_right, and for every lobe N,
//         1 is the uppermost: blade_flank_left_N, blade_flank_right_N, disc_flank_left_N,
//         disc_flank_right_N.

DefineConstant[
  lobes           = {3,    Min 2,     Max 4,   Name "Parameters/01 Number of pairs of lobes [-]", Step 1},
  pitch           = {8,    Min 1,     Max 50,  Name "Parameters/02 Distance from lobe to lobe along the wedge [mm]"},
  wedge_angle     = {14,   Min 0,     Max 30,  Name "Parameters/03 Angle of the line from lobe to lobe to the y axis [degrees]"},
  flank_angle     = {45,   Min 30,    Max 65,  Name "Parameters/04 Angle of the flanks to the x axis [degrees]"},
  flank_length    = {2.5,  Min 0.5,   Max 20,  Name "Parameters/05 Length of the flat of each blade flank [mm]"},
  upper_radius    = {1.6,  Min 0.2,   Max 20,  Name "Parameters/06 Radius of the rounding at the upper end of each flat [mm]"},
  lower_radius    = {1.6,  Min 0.2,   Max 20,  Name "Parameters/07 Radius of the rounding at the lower end of each flat [mm]"},
  contact_angle   = {10,   Min 3,     Max 20,  Name "Parameters/08 Part of each rounding that may touch [degrees]"},
  relief_angle    = {25,   Min 15,    Max 60,  Name "Parameters/09 Turn of the upper roundings before the neck fillets [degrees]"},
  neck_width      = {16,   Min 2,     Max 100, Name "Parameters/10 Width of the blade neck above the lobes [mm]"},
  neck_fillet     = {1.2,  Min 0.2,   Max 20,  Name "Parameters/11 Radius of the fillets of the blade, above each lobe [mm]"},
  root_height     = {5.5,  Min 0.5,   Max 50,  Name "Parameters/12 Height from the upper end of the lowest flat to the bottom of the blade [mm]"},
  root_corner     = {1,    Min 0.1,   Max 20,  Name "Parameters/13 Radius of the lower corners of the blade root [mm]"},
  flank_clearance = {0.3,  Min 0.01,  Max 5,   Name "Parameters/14 Gap between blade and disc at the backs of the lobes and at the walls [mm]"},
  slot_clearance  = {0.6,  Min 0.02,  Max 20,  Name "Parameters/15 Gap between blade and slot at the bottom [mm]"},
  lobe_gap        = {0,    Min -0.2,  Max 0.2, Name "Parameters/16 Step of the initial gap from lobe to lobe downwards, negative upwards [mm]"},
  tooth_radius    = {0.9,  Min 0.1,   Max 20,  Name "Parameters/17 Radius of the tips of the disc teeth [mm]"},
  groove_radius   = {1.1,  Min 0.1,   Max 20,  Name "Parameters/18 Radius of the grooves of the disc and of the corners of the slot [mm]"},
  rim_height      = {2,    Min 0.1,   Max 50,  Name "Parameters/19 Height of the straight wall beside the neck [mm]"},
  shank_height    = {10,   Min 0.5,   Max 100, Name "Parameters/20 Height of the blade top above the disc [mm]"},
  disc_width      = {44,   Min 4,     Max 500, Name "Parameters/21 Width of the disc block [mm]"},
  disc_depth      = {45,   Min 4,     Max 500, Name "Parameters/22 Height of the disc block or sector [mm]"},
  edge_size       = {0.0025,Min 1e-4, Max 1,   Name "Parameters/23 Element size at the contact edges [mm]"},
  edge_zone       = {0.12, Min 1e-3,  Max 5,   Name "Parameters/24 Length of the fine mesh on either side of the ends of the flats [mm]"},
  flank_size      = {0.1,  Min 1e-3,  Max 2,   Name "Parameters/25 Element size along the flanks [mm]"},
  growth          = {0.3,  Min 0.02,  Max 0.5, Name "Parameters/26 Growth of the element size per distance from the contact [-]"},
  sectors         = {0,    Min 0,     Max 1000,Name "Parameters/27 Number of sectors of the disc, 0 for a block [-]", Step 1},
  pitch_radius    = {250,  Min 10,    Max 5000,Name "Parameters/28 Radius from the axis of the disc to the middle of the flanks of lobe 1 [mm]"}
];

// Directions of the right flanks: (tx, ty) down along them, (nx, ny) out of the blade, at the angle
// `normal` to the x axis; (ux, uy) at `relieved`, out of the blade where the upper rounding ends.
degree = Pi / 180;
normal = (90 - flank_angle) * degree;
relieved = normal + relief_angle * degree;
touch = contact_angle * degree;
nx = Cos(normal); ny = Sin(normal);
tx = ny; ty = -nx;
ux = Cos(relieved); uy = Sin(relieved);

// Right half of lobe 1; y = 0 is half way down its flank. The neck fixes x: from the upper end of the
// flat the rounding turns towards the blade, the fillet turns back to the vertical neck.
neck = neck_width / 2;
fillet_x = neck + neck_fillet;
upper_cx = fillet_x - (upper_radius + neck_fillet) * ux;
upper_x = upper_cx + upper_radius * nx;
upper_y = -ty * flank_length / 2;
upper_cy = upper_y - upper_radius * ny;
fillet_y = upper_cy + (upper_radius + neck_fillet) * uy;
lower_x = upper_x + flank_length * tx;
lower_y = upper_y + flank_length * ty;
lower_cx = lower_x - lower_radius * nx;
lower_cy = lower_y - lower_radius * ny;

// Every lobe is the one above it, moved by (step_x, step_y). The back of a lobe is the straight line
// that touches its lower rounding and the fillet of the next lobe; (mx, my) is its normal.
step_x = -pitch * Sin(wedge_angle * degree);
step_y = -pitch * Cos(wedge_angle * degree);
dx = fillet_x + step_x - lower_cx;
dy = fillet_y + step_y - lower_cy;
back = Atan2(dy, dx) + Acos((lower_radius + neck_fillet) / Hypot(dx, dy));
mx = Cos(back); my = Sin(back);

// Levels and widths at the bottom and the top of the slot.
down_x = (lobes - 1) * step_x; down_y = (lobes - 1) * step_y;
root = lower_cx + down_x + lower_radius;
root_bottom = upper_y + down_y - root_height;
slot_bottom = root_bottom - slot_clearance;
slot = root + flank_clearance;
mouth = neck + flank_clearance;
If (lobe_gap >= 0)
  first_gap = 0;
Else
  first_gap = -lobe_gap * (lobes - 1);
EndIf

// Where the disc has its teeth and grooves. Lobe i lies (ox, oy) below lobe 1; the normals of the blade
// above and below it are at the angles above[i] and below[i] to the x axis. The flat of the disc lies at
// (nx, ny) . (x, y) = level, the line above it (back of the lobe above, or neck, and the clearance) at
// (ax, ay) . (x, y) = line, the line below it likewise.
above[] = {};
below[] = {};
teeth_x[] = {}; teeth_y[] = {};
grooves_x[] = {}; grooves_y[] = {};
For i In {0 : lobes - 1}
  ox = i * step_x; oy = i * step_y;
  gap = first_gap + lobe_gap * i;
  above[] += {(i == 0) ? 0 : back};
  below[] += {(i == lobes - 1) ? 0 : back};
  ax = Cos(above[i]); ay = Sin(above[i]);
  bx = Cos(below[i]); by = Sin(below[i]);
  level = (upper_x + ox) * nx + (upper_y + oy) * ny + gap;
  line = (fillet_x + ox) * ax + (fillet_y + oy) * ay - neck_fillet + flank_clearance;
  u = level + tooth_radius; v = line + tooth_radius; cross = nx * ay - ny * ax;
  teeth_x[] += {(u * ay - v * ny) / cross}; teeth_y[] += {(nx * v - ax * u) / cross};
  line = (lower_cx + ox) * bx + (lower_cy + oy) * by + lower_radius + flank_clearance;
  u = level - groove_radius; v = line - groove_radius; cross = nx * by - ny * bx;
  grooves_x[] += {(u * by - v * ny) / cross}; grooves_y[] += {(nx * v - bx * u) / cross};
EndFor

// Levels at the top of the slot and of the disc;
// the flat of the disc is a line of given (nx, ny) . (x, y), the wall beside the neck one of given x
mouth_cy = (upper_x * nx + upper_y * ny + first_gap + tooth_radius - (mouth + tooth_radius) * nx) / ny;
disc_top = mouth_cy + rim_height;
disc_base = disc_top - disc_depth;
blade_top = disc_top + shank_height;

// Upper and lower end of the right side of the disc, and its distance from the slot.
side_x = disc_width / 2; side_y = disc_base;
corner_x = side_x;
beside = side_x - slot;
bore = pitch_radius + disc_base;
If (sectors >= 3)
  half = Pi / sectors;
  corner_x = (pitch_radius + disc_top) * Tan(half);
  side_x = bore * Sin(half); side_y = bore * Cos(half) - pitch_radius;
  beside = (pitch_radius + slot_bottom) * Tan(half) - slot;
  For i In {0 : lobes - 1}
    beside = Min(beside, (pitch_radius + grooves_y[i]) * Tan(half) - grooves_x[i] - groove_radius);
  EndFor
EndIf

// What the parameters must satisfy together; a message begins with the name of its parameter.
wrong = 0;
// The backs of the lobes narrow outwards: their normal (vx, vy) points down by 80 degrees or less. It is
// at the pitch at which (F - L) . (vx, vy) is the sum of the radii, with F the centre of the fillet of
// lobe 2 and L that of the lower rounding of lobe 1.
vx = Cos(-80 * degree); vy = Sin(-80 * degree);
smallest_pitch = (lower_radius + neck_fillet - (fillet_x - lower_cx) * vx - (fillet_y - lower_cy) * vy)
                 * pitch / (step_x * vx + step_y * vy);
If (pitch < smallest_pitch)
  Error("pitch: expected at least %.6g (the backs of the lobes must slope by 10 degrees or more; a smaller flank_length, lower_radius, upper_radius or neck_fillet helps too), found %g", smallest_pitch, pitch); wrong = 1;
EndIf
most = Min(relief_angle, 90 - flank_angle) - 5;
If (contact_angle > most)
  Error("contact_angle: expected at most %.6g (5 degrees less than relief_angle and than 90 - flank_angle), found %g", most, contact_angle); wrong = 1;
EndIf
most = Min(0.9 * Min(upper_radius, lower_radius) * touch, 0.45 * flank_length);
If (edge_zone > most)
  Error("edge_zone: expected at most %.6g (nine tenths of the candidate contact on the smaller rounding, 45 percent of the flat), found %g", most, edge_zone); wrong = 1;
EndIf
narrower = -2 * down_x;
least = narrower / 0.85;
If (neck_width < least)
  Error("neck_width: expected at least %.6g (the lowest neck is %.6g narrower; a smaller wedge_angle or pitch helps), found %g", least, narrower, neck_width); wrong = 1;
EndIf
least = flank_length * nx + lower_radius * ny + root_corner + flank_size;
If (root_height < least)
  Error("root_height: expected at least %.6g (flat, lower rounding and root corner take that much; a smaller lower_radius helps), found %g", least, root_height); wrong = 1;
EndIf
// between the convex corner of the root and the concave corner of the slot around it
u = groove_radius - flank_clearance - root_corner;
v = groove_radius - slot_clearance - root_corner;
gap = groove_radius - root_corner - Hypot(u, v);
least = 0.5 * Min(flank_clearance, slot_clearance);
If (u > 0 && v > 0 && gap < least)
  Error("root_corner: the corners of the root, of radius %g, come too near to the corners of the slot, of radius %g: expected a gap of at least %.3g, found %.3g; a larger root_corner or a smaller groove_radius helps", root_corner, groove_radius, least, gap); wrong = 1;
EndIf
most = flank_length / 4;
If (flank_size > most)
  Error("flank_size: expected at most %.6g (a quarter of the flat), found %g", most, flank_size); wrong = 1;
EndIf
most = Min(flank_size, edge_zone / 2);
If (edge_size > most)
  Error("edge_size: expected at most %.6g (flank_size, and half of edge_zone), found %g", most, edge_size); wrong = 1;
EndIf
// Two lobes may be so near to each other that the back between them does not exist.
If (pitch >= smallest_pitch)
  // the straight pieces between the arcs, of the blade and of the disc
  straight = Sqrt(dx^2 + dy^2 - (lower_radius + neck_fillet)^2);
  For i In {1 : lobes - 1}
    straight = Min(straight, (teeth_x[i] - grooves_x[i - 1]) * my - (teeth_y[i] - grooves_y[i - 1]) * mx);
  EndFor
  If (straight < flank_size)
    Error("pitch: the straight backs of the lobes and of the disc teeth are only %.3g long, expected at least flank_size, %g, found pitch %g; a larger pitch, or smaller neck_fillet, tooth_radius or groove_radius helps", straight, flank_size, pitch); wrong = 1;
  EndIf
  turn = (relieved - back) / degree;
  If (turn > 170)
    Error("relief_angle: from the back of a lobe to the rounding below it the neck fillet turns by %.4g degrees, expected at most 170, found relief_angle %g; a larger pitch or flank_angle helps too", turn, relief_angle); wrong = 1;
  EndIf
  // how far the flats of the disc go on beyond the upper ends of those of the blade
  reach = upper_radius * Sin(touch) + flank_size;
  short = 0; most = tooth_radius; least = 0;
  For i In {0 : lobes - 1}
    ox = i * step_x; oy = i * step_y;
    missing = reach + ((teeth_x[i] - upper_x - ox) * tx + (teeth_y[i] - upper_y - oy) * ty);
    turn = normal - above[i];
    short = Max(short, missing);
    most = Min(most, tooth_radius - missing / Tan(turn / 2));
    least = Max(least, missing * Sin(turn) + flank_clearance);
  EndFor
  If (short > 0 && most > 0)
    Error("tooth_radius: expected at most %.6g (the flat of the disc must cover the candidate contact and an element of flank_size; a larger flank_clearance helps too), found %g", most, tooth_radius); wrong = 1;
  ElseIf (short > 0)
    Error("flank_clearance: expected at least %.6g (the flat of the disc must cover the candidate contact and an element of flank_size), found %g", least, flank_clearance); wrong = 1;
  EndIf
  // how far the flats of the disc go on beyond the lower ends of those of the blade
  reach = lower_radius * Sin(touch) + flank_size;
  short = 0; most = groove_radius; least = 0;
  For i In {0 : lobes - 1}
    ox = i * step_x; oy = i * step_y;
    missing = reach - ((grooves_x[i] - lower_x - ox) * tx + (grooves_y[i] - lower_y - oy) * ty);
    turn = normal - below[i];
    short = Max(short, missing);
    most = Min(most, groove_radius - missing / Tan(turn / 2));
    least = Max(least, missing * Sin(turn) + flank_clearance);
  EndFor
  If (short > 0 && most > 0)
    Error("groove_radius: expected at most %.6g (the flat of the disc must cover the candidate contact and an element of flank_size; a larger flank_clearance helps too), found %g", most, groove_radius); wrong = 1;
  ElseIf (short > 0)
    Error("flank_clearance: expected at least %.6g (the flat of the disc must cover the candidate contact and an element of flank_size), found %g", least, flank_clearance); wrong = 1;
  EndIf
  // between the tips of the teeth and the fillets around them, over the directions of the tip
  gap = 1e22; widest = 0;
  For i In {0 : lobes - 1}
    widest = Max(widest, grooves_x[i]);
    For j In {0 : 50}
      angle = above[i] + (normal - above[i]) * j / 50;
      gap = Min(gap, neck_fillet - tooth_radius - (fillet_x + i * step_x - teeth_x[i]) * Cos(angle)
                     - (fillet_y + i * step_y - teeth_y[i]) * Sin(angle));
    EndFor
  EndFor
  least = 0.5 * flank_clearance;
  If (gap < least)
    Error("tooth_radius: the tips of the disc teeth, of radius %g, come too near to the neck fillets of the blade, of radius %g: expected a gap of half of flank_clearance, %.3g, found %.3g; a larger tooth_radius or relief_angle, or a smaller neck_fillet or flank_clearance helps", tooth_radius, neck_fillet, least, gap); wrong = 1;
  EndIf
  least = slot_clearance + flank_size - (grooves_y[lobes - 1] - groove_radius - slot_bottom);
  If (slot_clearance < least)
    Error("slot_clearance: expected at least %.6g (the lowest groove and the slot corner must fit in; a smaller groove_radius helps), found %g", least, slot_clearance); wrong = 1;
  EndIf
  most = 0.7 * root;
  If (root_corner > most)
    Error("root_corner: expected at most %.6g (seven tenths of half the width of the root), found %g", most, root_corner); wrong = 1;
  EndIf
  most = 0.9 * slot;
  If (groove_radius > most)
    Error("groove_radius: expected at most %.6g (nine tenths of half the width of the slot), found %g", most, groove_radius); wrong = 1;
  EndIf
  least = fillet_y - disc_top + flank_size;
  If (shank_height < least)
    Error("shank_height: expected at least %.6g (the neck fillet must end below the top), found %g", least, shank_height); wrong = 1;
  EndIf
  least = 2 * (widest + 2 * groove_radius);
  If (sectors == 0 && disc_width < least)
    Error("disc_width: expected at least %.6g (width of the slot and its grooves), found %g", least, disc_width); wrong = 1;
  EndIf
  If (sectors > 0 && sectors < 3)
    Error("sectors: expected 0 (a block) or at least 3, found %g", sectors); wrong = 1;
  EndIf
  If (sectors >= 3 && beside < 2 * groove_radius)
    Error("sectors: expected at least %.6g between the slot and the sides of the sector, found %.6g (sectors %g); fewer sectors or a larger pitch_radius helps", 2 * groove_radius, beside, sectors); wrong = 1;
  EndIf
  least = disc_depth - disc_top + groove_radius;
  If (sectors >= 3 && pitch_radius < least)
    Error("pitch_radius: expected at least %.6g (the disc ends above its axis), found %g", least, pitch_radius); wrong = 1;
  EndIf
  least = disc_top - slot_bottom + groove_radius;
  If (disc_depth < least)
    Error("disc_depth: expected at least %.6g (depth of the slot and its corners), found %g", least, disc_depth); wrong = 1;
  EndIf
EndIf

// Everything from here to the end of the file is drawn only if nothing is wrong.
If (!wrong)

// Points on the axis of symmetry, shared by both halves of a body.
axis_blade_top = newp; Point(axis_blade_top) = {0, blade_top, 0};
axis_root = newp; Point(axis_root) = {0, root_bottom, 0};
axis_slot = newp; Point(axis_slot) = {0, slot_bottom, 0};
axis_disc = newp; Point(axis_disc) = {0, disc_base, 0};
disc_centre = newp; Point(disc_centre) = {0, -pitch_radius, 0};
blade_axis = newc; Line(blade_axis) = {axis_root, axis_blade_top};
disc_axis = newc; Line(disc_axis) = {axis_slot, axis_disc};

// Both halves; side is 1 (right) or -1 (left). Curves run from the top to the bottom.
fine[] = {};
contact[] = {};
fillets[] = {};
teeth[] = {};
grooves[] = {};
corners[] = {};
For side In {1 : -1 : -2}
  p = newp;
  Point(p)     = {side * neck, blade_top, 0};
  Point(p + 1) = {side * mouth, disc_top, 0};
  Point(p + 2) = {side * corner_x, disc_top, 0};
  Point(p + 3) = {side * side_x, side_y, 0};
  blade_end = p;
  disc_end = p + 1;
  c = newc;
  Line(c)     = {axis_blade_top, p};
  Line(c + 1) = {p + 3, p + 2};
  Line(c + 2) = {p + 2, p + 1};
  If (sectors > 0)
    Circle(c + 3) = {axis_disc, disc_centre, p + 3};
  Else
    Line(c + 3) = {axis_disc, p + 3};
  EndIf
  blade[] = {c};
  disc[] = {c + 3, c + 1, c + 2};

  For i In {0 : lobes - 1}
    ox = i * step_x; oy = i * step_y;
    gap = first_gap + lobe_gap * i;
    ax = Cos(above[i]); ay = Sin(above[i]);
    bx = Cos(below[i]); by = Sin(below[i]);
    tooth_x = teeth_x[i]; tooth_y = teeth_y[i];
    groove_x = grooves_x[i]; groove_y = grooves_y[i];

    p = newp;
    Point(p)      = {side * (fillet_x + ox - neck_fillet * ax), fillet_y + oy - neck_fillet * ay, 0};
    Point(p + 1)  = {side * (fillet_x + ox), fillet_y + oy, 0};
    Point(p + 2)  = {side * (upper_cx + ox + upper_radius * ux), upper_cy + oy + upper_radius * uy, 0};
    Point(p + 3)  = {side * (upper_cx + ox), upper_cy + oy, 0};
    angle = normal + touch;
    Point(p + 4)  = {side * (upper_cx + ox + upper_radius * Cos(angle)), upper_cy + oy + upper_radius * Sin(angle), 0};
    angle = normal + edge_zone / upper_radius;
    Point(p + 5)  = {side * (upper_cx + ox + upper_radius * Cos(angle)), upper_cy + oy + upper_radius * Sin(angle), 0};
    Point(p + 6)  = {side * (upper_x + ox), upper_y + oy, 0};
    Point(p + 7)  = {side * (upper_x + ox + edge_zone * tx), upper_y + oy + edge_zone * ty, 0};
    Point(p + 8)  = {side * (lower_x + ox - edge_zone * tx), lower_y + oy - edge_zone * ty, 0};
    Point(p + 9)  = {side * (lower_x + ox), lower_y + oy, 0};
    Point(p + 10) = {side * (lower_cx + ox), lower_cy + oy, 0};
    angle = normal - edge_zone / lower_radius;
    Point(p + 11) = {side * (lower_cx + ox + lower_radius * Cos(angle)), lower_cy + oy + lower_radius * Sin(angle), 0};
    angle = normal - touch;
    Point(p + 12) = {side * (lower_cx + ox + lower_radius * Cos(angle)), lower_cy + oy + lower_radius * Sin(angle), 0};
    Point(p + 13) = {side * (lower_cx + ox + lower_radius * bx), lower_cy + oy + lower_radius * by, 0};
    c = newc;
    Line(c)        = {blade_end, p};           // neck, or back of the lobe above
    Circle(c + 1)  = {p, p + 1, p + 2};
    Circle(c + 2)  = {p + 2, p + 3, p + 4};
    Circle(c + 3)  = {p + 4, p + 3, p + 5};    // contact: upper rounding
    Circle(c + 4)  = {p + 5, p + 3, p + 6};    //   fine
    Line(c + 5)    = {p + 6, p + 7};           //   fine
    Line(c + 6)    = {p + 7, p + 8};           //   flat
    Line(c + 7)    = {p + 8, p + 9};           //   fine
    Circle(c + 8)  = {p + 9, p + 10, p + 11};  //   fine
    Circle(c + 9)  = {p + 11, p + 10, p + 12}; // contact: lower rounding
    Circle(c + 10) = {p + 12, p + 10, p + 13};
    blade[] += {c : c + 10};
    blade_end = p + 13;
    blade_flank[] = {c + 3 : c + 9};
    fine[] += {c + 4, c + 5, c + 7, c + 8};
    fillets[] += {c + 1};

    gx = ox + gap * nx; gy = oy + gap * ny;

    p = newp;
    Point(p)      = {side * (tooth_x - tooth_radius * ax), tooth_y - tooth_radius * ay, 0};
    Point(p + 1)  = {side * tooth_x, tooth_y, 0};
    Point(p + 2)  = {side * (tooth_x - tooth_radius * nx), tooth_y - tooth_radius * ny, 0};
    reach = upper_radius * Sin(touch);
    Point(p + 3)  = {side * (upper_x + gx - reach * tx), upper_y + gy - reach * ty, 0};
    Point(p + 4)  = {side * (upper_x + gx - edge_zone * tx), upper_y + gy - edge_zone * ty, 0};
    Point(p + 5)  = {side * (upper_x + gx + edge_zone * tx), upper_y + gy + edge_zone * ty, 0};
    Point(p + 6)  = {side * (lower_x + gx - edge_zone * tx), lower_y + gy - edge_zone * ty, 0};
    Point(p + 7)  = {side * (lower_x + gx + edge_zone * tx), lower_y + gy + edge_zone * ty, 0};
    reach = lower_radius * Sin(touch);
    Point(p + 8)  = {side * (lower_x + gx + reach * tx), lower_y + gy + reach * ty, 0};
    Point(p + 9)  = {side * (groove_x + groove_radius * nx), groove_y + groove_radius * ny, 0};
    Point(p + 10) = {side * groove_x, groove_y, 0};
    Point(p + 11) = {side * (groove_x + groove_radius * bx), groove_y + groove_radius * by, 0};
    c = newc;
    Line(c)        = {disc_end, p};            // wall beside the neck, or back of a tooth
    Circle(c + 1)  = {p, p + 1, p + 2};
    Line(c + 2)    = {p + 2, p + 3};
    Line(c + 3)    = {p + 3, p + 4};           // contact: opposite the upper rounding
    Line(c + 4)    = {p + 4, p + 5};           //   fine
    Line(c + 5)    = {p + 5, p + 6};           //   opposite the flat
    Line(c + 6)    = {p + 6, p + 7};           //   fine
    Line(c + 7)    = {p + 7, p + 8};           // contact: opposite the lower rounding
    Line(c + 8)    = {p + 8, p + 9};
    Circle(c + 9)  = {p + 9, p + 10, p + 11};
    disc[] += {c : c + 9};
    disc_end = p + 11;
    disc_flank[] = {c + 3 : c + 7};
    fine[] += {c + 4, c + 6};
    contact[] += {blade_flank[], disc_flank[]};
    teeth[] += {c + 1};
    grooves[] += {c + 9};

    If (side > 0)
      Physical Curve(Sprintf("blade_flank_right_%g", i + 1)) = {blade_flank[]};
      Physical Curve(Sprintf("disc_flank_right_%g", i + 1)) = {disc_flank[]};
    Else
      Physical Curve(Sprintf("blade_flank_left_%g", i + 1)) = {blade_flank[]};
      Physical Curve(Sprintf("disc_flank_left_%g", i + 1)) = {disc_flank[]};
    EndIf
  EndFor

  p = newp;
  Point(p)     = {side * root, root_bottom + root_corner, 0};
  Point(p + 1) = {side * (root - root_corner), root_bottom + root_corner, 0};
  Point(p + 2) = {side * (root - root_corner), root_bottom, 0};
  Point(p + 3) = {side * slot, slot_bottom + groove_radius, 0};
  Point(p + 4) = {side * (slot - groove_radius), slot_bottom + groove_radius, 0};
  Point(p + 5) = {side * (slot - groove_radius), slot_bottom, 0};
  c = newc;
  Line(c)       = {blade_end, p};
  Circle(c + 1) = {p, p + 1, p + 2};
  Line(c + 2)   = {p + 2, axis_root};
  Line(c + 3)   = {disc_end, p + 3};
  Circle(c + 4) = {p + 3, p + 4, p + 5};
  Line(c + 5)   = {p + 5, axis_slot};
  blade[] += {c : c + 2};
  disc[] += {c + 3 : c + 5};
  corners[] += {c + 1};
  grooves[] += {c + 4};

  If (side > 0)
    blade_right[] = blade[];
    disc_right[] = disc[];
  Else
    blade_left[] = blade[];
    disc_left[] = disc[];
  EndIf
EndFor

Curve Loop(1) = {blade_right[], blade_axis}; Plane Surface(1) = {1};
Curve Loop(2) = {blade_left[], blade_axis};  Plane Surface(2) = {2};
Curve Loop(3) = {disc_right[], disc_axis};   Plane Surface(3) = {3};
Curve Loop(4) = {disc_left[], disc_axis};    Plane Surface(4) = {4};
mirror[] = {-1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
Periodic Surface {2} = {1} Affine {mirror[]};
Periodic Surface {4} = {3} Affine {mirror[]};

Physical Surface("blade") = {1, 2};
Physical Surface("disc") = {3, 4};
Physical Curve("blade_top") = {blade_right[0], blade_left[0]};
Physical Curve("disc_bottom") = {disc_right[0], disc_left[0]};
Physical Curve("disc_side_right") = {disc_right[1]};
Physical Curve("disc_side_left") = {disc_left[1]};

// Element size: the distance is that from the nearer surface, so that both bodies are graded alike.
// Elements are not larger than the arcs beside them and the walls around them.
Field[1] = Distance;
Field[1].CurvesList = {fine[]};
Field[1].Sampling = 100;
Field[2] = Distance;
Field[2].CurvesList = {contact[]};
Field[2].Sampling = 200;
Field[3] = Distance;
Field[3].CurvesList = {fillets[]};
Field[4] = Distance;
Field[4].CurvesList = {corners[]};
Field[5] = Distance;
Field[5].CurvesList = {grooves[]};
Field[6] = Distance;
Field[6].CurvesList = {teeth[]};
contact_size = Sprintf("Min(%g + %g*F1, %g + %g*F2)", edge_size, growth, flank_size, growth);
blade_size = Sprintf("Min(Min(%g + %g*F3, %g + %g*F4), %g)",
                     neck_fillet, growth, root_corner, growth, Min(neck, root));
disc_size = Sprintf("Min(Min(%g + %g*F5, %g + %g*F6), %g)",
                    groove_radius, growth, tooth_radius, growth,
                    Min(beside, slot_bottom - disc_base));
Field[7] = MathEval;
Field[7].F = StrCat("Min(", contact_size, ",", blade_size, ")");
Field[8] = Restrict;
Field[8].InField = 7;
Field[8].SurfacesList = {1, 2};
Field[9] = MathEval;
Field[9].F = StrCat("1.07 * Min(", contact_size, ",", disc_size, ")");
Field[10] = Restrict;
Field[10].InField = 9;
Field[10].SurfacesList = {3, 4};
Field[11] = Min;
Field[11].FieldsList = {8, 10};
Background Field = 11;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 6;

EndIf

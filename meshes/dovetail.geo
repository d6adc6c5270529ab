// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Dovetail: a blade root in the slot of a disc, plane, symmetric about x = 0. Lengths in mm.
// Pulling the blade top upwards presses the two flanks of the root against the flanks of the slot.
//
//   right half, not to scale                             blade_top
//                                                     x=0 _________
//                                                      |           |
//                                                      |   blade   |        ^ shank_height
//   neck_width / 2 = width from x = 0 to the neck      |           |        v
//                                                      |           | ._______________ (disc top)
//   neck_fillet  = concave radius under the neck       |           | |             | ^
//   mouth_radius = edge of the slot,                   |           | | mouth_height| |
//     above it a straight wall, mouth_height           |          /   \            | |
//                                                      |         (     \           | |
//   relief_angle = how far the upper rounding turns    |          \_    \  disc    | |
//                                                 __   |    upper_ \.    \         | |
//   flank: flat of length flank_length,           ^    |     radius  \    \        | |
//     flank_angle to the x axis, between          |    |      flank   \    \       | disc_depth
//     two roundings; the flat of the disc        root_ |        length \    \      | |
//     is longer by overhang at both ends         height|                \.   \     | |
//                                                 |    |     lower_radius )   )    | |
//   root_corner = lower corners of the blade      v    |__________________/  /     | |
//   slot_fillet = all corners of the slot         __   |_slot_clearance_____/      | |
//                                                      |                           | |
//                                                      |___________________________| v
//                                                      <------ disc_width / 2 ----->
//
// At the start the flats touch (gap zero) and the roundings curve away from the disc, so each flank
// is a flat punch with rounded ends. With upper_on_disc = 1 the flat of the blade goes on by overhang
// at the upper end, and the edge of the slot is the rounding, of upper_radius. The candidate contact surfaces are the flat and the first
// contact_angle of each rounding, and what lies opposite on the disc. The blade is mesh side 1, the
// disc 7 % coarser, so the meshes do not match.
//
// With sectors > 0 the disc is a sector of one: its sides are radial, its bottom is an arc, the bore,
// and disc_width has no meaning. The axis of the disc is at (0, -pitch_radius); the middle of the
// flanks, at y = 0, is as far from it.
//
// Element size: edge_size along the four contact edges (from edge_zone before to edge_zone behind
// places on the roundings, upper_front and lower_front from the flat), flank_size on the rest of the candidate contact surfaces,
// and from there growing by `growth` per distance. The left half of the mesh mirrors the right half.
//
// Groups: blade, disc; blade_top, disc_bottom, disc_side_left, disc_side_right,
//         blade_flank_left, blade_flank_right, disc_flank_left, disc_flank_right.

DefineConstant[
  flank_angle    = {45,   Min 30,    Max 70,  Name "Parameters/01 Angle of the flank to the x axis [degrees]"},
  flank_length   = {6,    Min 2,     Max 30,  Name "Parameters/02 Length of the flat of the blade flank [mm]"},
  upper_radius   = {4,    Min 0.5,   Max 50,  Name "Parameters/03 Radius of the rounding at the upper end of the flat [mm]"},
  lower_radius   = {4,    Min 0.5,   Max 50,  Name "Parameters/04 Radius of the rounding at the lower end of the flat [mm]"},
  contact_angle  = {10,   Min 3,     Max 20,  Name "Parameters/05 Part of each rounding that may touch [degrees]"},
  overhang       = {2,    Min 0.2,   Max 20,  Name "Parameters/06 Flat of the disc flank beyond each end of the blade flat [mm]"},
  relief_angle   = {30,   Min 15,    Max 60,  Name "Parameters/07 Turn of the upper rounding before the neck fillet [degrees]"},
  neck_width     = {12,   Min 2,     Max 100, Name "Parameters/08 Width of the blade neck [mm]"},
  neck_fillet    = {2.5,  Min 0.5,   Max 30,  Name "Parameters/09 Radius of the fillet between flank and neck [mm]"},
  root_height    = {12,   Min 2,     Max 100, Name "Parameters/10 Height of the blade root, from the upper end of the flat to its bottom [mm]"},
  root_corner    = {2,    Min 0.2,   Max 30,  Name "Parameters/11 Radius of the lower corners of the blade root [mm]"},
  slot_clearance = {1.5,  Min 0.05,  Max 30,  Name "Parameters/12 Gap between blade and slot at the bottom [mm]"},
  slot_fillet    = {3,    Min 0.3,   Max 30,  Name "Parameters/13 Radius of the fillets in the slot [mm]"},
  mouth_radius   = {1,    Min 0.1,   Max 20,  Name "Parameters/14 Radius of the edge at the mouth of the slot, unless upper_on_disc [mm]"},
  mouth_height   = {3,    Min 0.1,   Max 50,  Name "Parameters/15 Height of the straight wall at the mouth of the slot [mm]"},
  shank_height   = {12,   Min 1,     Max 100, Name "Parameters/16 Height of the blade top above the disc [mm]"},
  disc_width     = {60,   Min 5,     Max 500, Name "Parameters/17 Width of the disc block [mm]"},
  disc_depth     = {45,   Min 5,     Max 500, Name "Parameters/18 Height of the disc block or sector [mm]"},
  edge_size      = {0.003,Min 1e-4,  Max 1,   Name "Parameters/19 Element size at the contact edges [mm]"},
  edge_zone      = {0.25, Min 1e-3,  Max 5,   Name "Parameters/20 Length of the fine mesh on either side of its middle [mm]"},
  flank_size     = {0.15, Min 1e-3,  Max 2,   Name "Parameters/21 Element size along the flank [mm]"},
  growth         = {0.3,  Min 0.02,  Max 0.5, Name "Parameters/22 Growth of the element size per distance from the contact [-]"},
  sectors        = {0,    Min 0,     Max 1000,Name "Parameters/23 Number of sectors of the disc, 0 for a block [-]", Step 1},
  pitch_radius   = {250,  Min 10,    Max 5000,Name "Parameters/24 Radius from the axis of the disc to the middle of the flanks [mm]"},
  upper_front    = {0,    Min 0,     Max 20,  Name "Parameters/25 Distance of the middle of the fine mesh from the upper end of the flat, on the rounding [mm]"},
  lower_front    = {0,    Min 0,     Max 20,  Name "Parameters/26 Distance of the middle of the fine mesh from the lower end of the flat, on the rounding [mm]"},
  upper_on_disc  = {0,    Min 0,     Max 1,   Name "Parameters/27 Upper rounding on the disc (1) or the blade (0) [-]", Step 1}
];

// Angles, and the directions of the right flank: (tx, ty) down along it, (nx, ny) out of the blade.
degree = Pi / 180;
flank = flank_angle * degree;
relief = relief_angle * degree;
touch = contact_angle * degree;
tx = Cos(flank); ty = -Sin(flank);
nx = Sin(flank); ny = Cos(flank);

// Ends of the flat; y = 0 is half way down the flank. The neck fixes x: from the upper end of the flat
// the rounding turns by the relief angle towards the blade, the fillet turns back to the vertical neck.
neck = neck_width / 2;
turned_x = Sin(flank - relief); turned_y = Cos(flank - relief);
upper_x = neck + neck_fillet + upper_radius * nx - (upper_radius + neck_fillet) * turned_x;
If (upper_on_disc)
  // the fillet of the neck begins where the flat of the blade ends
  upper_x = neck + neck_fillet * (1 - nx) + overhang * tx;
EndIf
upper_y = -ty * flank_length / 2;
lower_x = upper_x + flank_length * tx;
lower_y = -upper_y;

// Centres of the arcs, and the levels and widths they lead to.
upper_cx = upper_x - upper_radius * nx; upper_cy = upper_y - upper_radius * ny;
lower_cx = lower_x - lower_radius * nx; lower_cy = lower_y - lower_radius * ny;
neck_cx = upper_cx + (upper_radius + neck_fillet) * turned_x;
neck_cy = upper_cy + (upper_radius + neck_fillet) * turned_y;
If (upper_on_disc)
  neck_cx = upper_x - overhang * tx + neck_fillet * nx;
  neck_cy = upper_y - overhang * ty + neck_fillet * ny;
EndIf
root = lower_cx + lower_radius;
root_bottom = upper_y - root_height;
slot_bottom = root_bottom - slot_clearance;
slot_x = lower_x + overhang * tx; slot_y = lower_y + overhang * ty;
slot_cx = slot_x - slot_fillet * nx; slot_cy = slot_y - slot_fillet * ny;
slot = slot_cx + slot_fillet;
mouth_x = upper_x - overhang * tx; mouth_y = upper_y - overhang * ty; edge_radius = mouth_radius;
If (upper_on_disc)
  mouth_x = upper_x; mouth_y = upper_y; edge_radius = upper_radius;
EndIf
mouth_cx = mouth_x + edge_radius * nx; mouth_cy = mouth_y + edge_radius * ny;
mouth = mouth_cx - edge_radius;
disc_top = mouth_cy + mouth_height;
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
EndIf

// What the parameters must satisfy together; a message begins with the name of its parameter.
// Outside the contact surfaces the bodies stay apart by `apart`, far more than elastic displacements.
wrong = 0;
apart = 0.01 * neck_width;
most = Min(relief_angle, 90 - flank_angle) - 5;
If (contact_angle > most)
  Error("contact_angle: expected at most %.6g (5 degrees less than relief_angle and than 90 - flank_angle), found %g", most, contact_angle); wrong = 1;
EndIf
least = Max(upper_radius, lower_radius) * Sin(touch) + flank_size;
If (overhang < least)
  Error("overhang: expected at least %.6g (the flat of the disc must cover the candidate contact on the larger rounding), found %g", least, overhang); wrong = 1;
EndIf
most = 0.8 * touch * upper_radius;
If (upper_front > most)
  Error("upper_front: expected at most %.6g (eight tenths of the candidate contact on the rounding), found %g", most, upper_front); wrong = 1;
EndIf
most = 0.8 * touch * lower_radius;
If (lower_front > most)
  Error("lower_front: expected at most %.6g (eight tenths of the candidate contact on the rounding), found %g", most, lower_front); wrong = 1;
EndIf
most = edge_zone - edge_size;
If (upper_on_disc && upper_front > most)
  Error("upper_front: expected at most %.6g with upper_on_disc (edge_zone less edge_size: the fine mesh begins on the flat), found %g", most, upper_front); wrong = 1;
EndIf
most = Min(0.9 * touch * upper_radius - upper_front, 0.9 * touch * lower_radius - lower_front);
most = Min(most, 0.45 * flank_length);
If (edge_zone > most)
  Error("edge_zone: expected at most %.6g (nine tenths of the candidate contact on each rounding, less upper_front or lower_front; 45 percent of the flat), found %g", most, edge_zone); wrong = 1;
EndIf
least = flank_length * nx + lower_radius * ny + root_corner + flank_size;
If (root_height < least)
  Error("root_height: expected at least %.6g (flat, lower rounding and root corner take that much; a smaller lower_radius helps), found %g", least, root_height); wrong = 1;
EndIf
least = (flank_length + overhang) * nx + slot_fillet * (1 + ny) + flank_size - root_height;
If (slot_clearance < least)
  Error("slot_clearance: expected at least %.6g (the flat of the disc and the slot fillets must fit in; a smaller slot_fillet helps), found %g", least, slot_clearance); wrong = 1;
EndIf
least = overhang + (apart - (slot - root)) / ny;
If (overhang < least)
  Error("overhang: expected at least %.6g (the blade root would touch the side wall of the slot; a larger slot_fillet helps too), found %g", least, overhang); wrong = 1;
EndIf
// between the convex corner of the root and the concave fillet of the slot around it
dx = (root - root_corner) - (slot - slot_fillet);
dy = (slot_fillet - slot_clearance) - root_corner;
gap = slot_fillet - root_corner - Hypot(dx, dy);
If (dx > 0 && dy > 0 && gap < apart)
  Error("root_corner: the corners of the root, of radius %g, come too near to the fillets of the slot, of radius %g: expected a gap of at least %.3g, found %.3g; a larger root_corner, overhang or slot_clearance or a smaller slot_fillet helps", root_corner, slot_fillet, apart, gap); wrong = 1;
EndIf
// between the edge of the slot and the neck with its fillet, over their directions
gap = neck_width;
// with upper_on_disc they touch along the normal of the flank, and part on the way to the neck
last = upper_on_disc ? 0 : 50;
For i In {0 : last}
  angle = (Pi / 2 - flank) * i / 50;
  gap = Min(gap, neck_fillet - edge_radius - (neck_cx - mouth_cx) * Cos(angle) - (neck_cy - mouth_cy) * Sin(angle));
EndFor
If (gap < apart && upper_on_disc)
  Error("upper_radius: the rounding of the disc would touch the fillet of the neck: expected a gap of at least %.3g, found %.3g; a smaller upper_radius, or a larger overhang or neck_fillet helps", apart, gap); wrong = 1;
EndIf
If (gap < apart && !upper_on_disc)
  Error("neck_width: the neck with its fillets does not pass through the mouth of the slot, which is %.6g wide: expected a gap of at least %.3g, found %.3g (neck_width %g); a smaller overhang or mouth_radius or a larger neck_fillet helps", 2 * mouth, apart, gap, neck_width); wrong = 1;
EndIf
most = 0.9 * root;
If (root_corner > most)
  Error("root_corner: expected at most %.6g (nine tenths of half the width of the root), found %g", most, root_corner); wrong = 1;
EndIf
most = 0.9 * slot;
If (slot_fillet > most)
  Error("slot_fillet: expected at most %.6g (nine tenths of half the width of the slot), found %g", most, slot_fillet); wrong = 1;
EndIf
least = neck_cy - disc_top + flank_size;
If (shank_height < least)
  Error("shank_height: expected at least %.6g (the neck fillet must end below the top), found %g", least, shank_height); wrong = 1;
EndIf
least = 2 * (slot + slot_fillet);
If (sectors > 0 && sectors < 3)
  Error("sectors: expected 0 (a block) or at least 3, found %g", sectors); wrong = 1;
EndIf
If (sectors >= 3 && beside < slot_fillet)
  Error("sectors: expected at least %.6g between the slot and the sides of the sector, found %.6g (sectors %g); fewer sectors or a larger pitch_radius helps", slot_fillet, beside, sectors); wrong = 1;
EndIf
least = disc_depth - disc_top + slot_fillet;
If (sectors >= 3 && pitch_radius < least)
  Error("pitch_radius: expected at least %.6g (the disc ends above its axis), found %g", least, pitch_radius); wrong = 1;
EndIf
least = 2 * (slot + slot_fillet);
If (sectors == 0 && disc_width < least)
  Error("disc_width: expected at least %.6g (width of the slot and its fillets), found %g", least, disc_width); wrong = 1;
EndIf
least = disc_top - slot_bottom + slot_fillet;
If (disc_depth < least)
  Error("disc_depth: expected at least %.6g (depth of the slot and its fillets), found %g", least, disc_depth); wrong = 1;
EndIf
most = flank_length / 4;
If (flank_size > most)
  Error("flank_size: expected at most %.6g (a quarter of the flat), found %g", most, flank_size); wrong = 1;
EndIf
most = Min(flank_size, edge_zone / 2);
If (edge_size > most)
  Error("edge_size: expected at most %.6g (flank_size, and half of edge_zone), found %g", most, edge_size); wrong = 1;
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

// The fine mesh ends so far inward of the ends of the flat; where that is on the rounding, the end of
// the flat comes first on the way down (upper) or last (lower).
// Next to the end of the flat it ends an element beyond.
upper_inner = edge_zone - upper_front; lower_inner = edge_zone - lower_front;
If (Fabs(upper_inner) < edge_size)
  upper_inner = edge_size;
EndIf
If (Fabs(lower_inner) < edge_size)
  lower_inner = edge_size;
EndIf
upper_end = 7; upper_fine = 8; lower_fine = 9; lower_end = 10;
fine[] = {5, 9};
If (upper_inner > 0)
  fine[] += {6};
Else
  upper_end = 8; upper_fine = 7;
EndIf
If (lower_inner > 0)
  fine[] += {8};
Else
  lower_end = 9; lower_fine = 10;
EndIf

// Both halves of the blade; side is 1 (right) or -1 (left). Curves run from the top to the bottom.
For side In {1 : -1 : -2}
  p = newp;
  Point(p)      = {side * neck, blade_top, 0};
  Point(p + 1)  = {side * neck, neck_cy, 0};
  Point(p + 2)  = {side * neck_cx, neck_cy, 0};
  If (upper_on_disc)
    Point(p + 3) = {side * (upper_x - overhang * tx), upper_y - overhang * ty, 0};
    reach = upper_radius * Sin(touch);
    Point(p + 5) = {side * (upper_x - reach * tx), upper_y - reach * ty, 0};
    reach = upper_front + edge_zone;
    Point(p + 6) = {side * (upper_x - reach * tx), upper_y - reach * ty, 0};
  Else
    Point(p + 3) = {side * (upper_cx + upper_radius * turned_x), upper_cy + upper_radius * turned_y, 0};
    Point(p + 4) = {side * upper_cx, upper_cy, 0};
    angle = flank - touch;
    Point(p + 5) = {side * (upper_cx + upper_radius * Sin(angle)), upper_cy + upper_radius * Cos(angle), 0};
    angle = flank - (upper_front + edge_zone) / upper_radius;
    Point(p + 6) = {side * (upper_cx + upper_radius * Sin(angle)), upper_cy + upper_radius * Cos(angle), 0};
  EndIf
  Point(upper_end + p) = {side * upper_x, upper_y, 0};
  angle = flank + Min(upper_inner, 0) / upper_radius;
  Point(upper_fine + p) = {side * (upper_cx + upper_radius * Sin(angle) + Max(upper_inner, 0) * tx),
                           upper_cy + upper_radius * Cos(angle) + Max(upper_inner, 0) * ty, 0};
  angle = flank - Min(lower_inner, 0) / lower_radius;
  Point(lower_fine + p) = {side * (lower_cx + lower_radius * Sin(angle) - Max(lower_inner, 0) * tx),
                           lower_cy + lower_radius * Cos(angle) - Max(lower_inner, 0) * ty, 0};
  Point(lower_end + p) = {side * lower_x, lower_y, 0};
  Point(p + 11) = {side * lower_cx, lower_cy, 0};
  angle = flank + (lower_front + edge_zone) / lower_radius;
  Point(p + 12) = {side * (lower_cx + lower_radius * Sin(angle)), lower_cy + lower_radius * Cos(angle), 0};
  angle = flank + touch;
  Point(p + 13) = {side * (lower_cx + lower_radius * Sin(angle)), lower_cy + lower_radius * Cos(angle), 0};
  Point(p + 14) = {side * root, lower_cy, 0};
  Point(p + 15) = {side * root, root_bottom + root_corner, 0};
  Point(p + 16) = {side * (root - root_corner), root_bottom + root_corner, 0};
  Point(p + 17) = {side * (root - root_corner), root_bottom, 0};
  c = newc;
  Line(c)        = {axis_blade_top, p};
  Line(c + 1)    = {p, p + 1};
  Circle(c + 2)  = {p + 1, p + 2, p + 3};
  If (upper_on_disc)
    Line(c + 3)  = {p + 3, p + 5};
    Line(c + 4)  = {p + 5, p + 6};           // contact: opposite the upper rounding
    Line(c + 5)  = {p + 6, p + 7};           //   fine
  Else
    Circle(c + 3) = {p + 3, p + 4, p + 5};
    Circle(c + 4) = {p + 5, p + 4, p + 6};   // contact: upper rounding
    Circle(c + 5) = {p + 6, p + 4, p + 7};   //   fine
  EndIf
  If (upper_inner > 0)
    Line(c + 6)  = {p + 7, p + 8};           //   fine
  Else
    Circle(c + 6) = {p + 7, p + 4, p + 8};
  EndIf
  Line(c + 7)    = {p + 8, p + 9};           //   flat
  If (lower_inner > 0)
    Line(c + 8)  = {p + 9, p + 10};          //   fine
  Else
    Circle(c + 8) = {p + 9, p + 11, p + 10};
  EndIf
  Circle(c + 9)  = {p + 10, p + 11, p + 12}; //   fine
  Circle(c + 10) = {p + 12, p + 11, p + 13}; // contact: lower rounding
  Circle(c + 11) = {p + 13, p + 11, p + 14};
  Line(c + 12)   = {p + 14, p + 15};
  Circle(c + 13) = {p + 15, p + 16, p + 17};
  Line(c + 14)   = {p + 17, axis_root};
  If (side > 0)
    blade_right[] = {c : c + 14};
  Else
    blade_left[] = {c : c + 14};
  EndIf
EndFor

// Both halves of the disc; curves run from the bottom of the slot up its wall and round the block.
For side In {1 : -1 : -2}
  p = newp;
  Point(p)      = {side * (slot - slot_fillet), slot_bottom, 0};
  Point(p + 1)  = {side * (slot - slot_fillet), slot_bottom + slot_fillet, 0};
  Point(p + 2)  = {side * slot, slot_bottom + slot_fillet, 0};
  Point(p + 3)  = {side * slot, slot_cy, 0};
  Point(p + 4)  = {side * slot_cx, slot_cy, 0};
  Point(p + 5)  = {side * slot_x, slot_y, 0};
  reach = lower_radius * Sin(touch);
  Point(p + 6)  = {side * (lower_x + reach * tx), lower_y + reach * ty, 0};
  reach = lower_front + edge_zone;
  Point(p + 7)  = {side * (lower_x + reach * tx), lower_y + reach * ty, 0};
  Point(p + 8)  = {side * (lower_x - lower_inner * tx), lower_y - lower_inner * ty, 0};
  Point(p + 9)  = {side * (upper_x + upper_inner * tx), upper_y + upper_inner * ty, 0};
  If (upper_on_disc)
    angle = flank + (upper_front + edge_zone) / upper_radius;
    Point(p + 10) = {side * (mouth_cx - upper_radius * Sin(angle)), mouth_cy - upper_radius * Cos(angle), 0};
    angle = flank + touch;
    Point(p + 11) = {side * (mouth_cx - upper_radius * Sin(angle)), mouth_cy - upper_radius * Cos(angle), 0};
    angle = (flank + touch + Pi / 2) / 2;
    Point(p + 12) = {side * (mouth_cx - upper_radius * Sin(angle)), mouth_cy - upper_radius * Cos(angle), 0};
    Point(p + 18) = {side * upper_x, upper_y, 0};
  Else
    reach = upper_front + edge_zone;
    Point(p + 10) = {side * (upper_x - reach * tx), upper_y - reach * ty, 0};
    reach = upper_radius * Sin(touch);
    Point(p + 11) = {side * (upper_x - reach * tx), upper_y - reach * ty, 0};
    Point(p + 12) = {side * mouth_x, mouth_y, 0};
  EndIf
  Point(p + 13) = {side * mouth_cx, mouth_cy, 0};
  Point(p + 14) = {side * mouth, mouth_cy, 0};
  Point(p + 15) = {side * mouth, disc_top, 0};
  Point(p + 16) = {side * corner_x, disc_top, 0};
  Point(p + 17) = {side * side_x, side_y, 0};
  c = newc;
  Line(c)        = {axis_slot, p};
  Circle(c + 1)  = {p, p + 1, p + 2};
  Line(c + 2)    = {p + 2, p + 3};
  Circle(c + 3)  = {p + 3, p + 4, p + 5};
  Line(c + 4)    = {p + 5, p + 6};
  Line(c + 5)    = {p + 6, p + 7};           // contact: opposite the lower rounding
  Line(c + 6)    = {p + 7, p + 8};           //   fine
  Line(c + 7)    = {p + 8, p + 9};           //   opposite the flat
  more[] = {};
  If (upper_on_disc)
    more[] = {c + 16};
    Line(c + 16)   = {p + 9, p + 18};        //   fine
    Circle(c + 8)  = {p + 18, p + 13, p + 10}; // fine
    Circle(c + 9)  = {p + 10, p + 13, p + 11}; // contact: upper rounding
    Circle(c + 10) = {p + 11, p + 13, p + 12};
  Else
    Line(c + 8)    = {p + 9, p + 10};        //   fine
    Line(c + 9)    = {p + 10, p + 11};       // contact: opposite the upper rounding
    Line(c + 10)   = {p + 11, p + 12};
  EndIf
  Circle(c + 11) = {p + 12, p + 13, p + 14};
  Line(c + 12)   = {p + 14, p + 15};
  Line(c + 13)   = {p + 15, p + 16};
  Line(c + 14)   = {p + 16, p + 17};
  If (sectors > 0)
    Circle(c + 15) = {p + 17, disc_centre, axis_disc};
  Else
    Line(c + 15) = {p + 17, axis_disc};
  EndIf
  If (side > 0)
    disc_right[] = {c : c + 15}; more_right[] = more[];
  Else
    disc_left[] = {c : c + 15}; more_left[] = more[];
  EndIf
EndFor

Curve Loop(1) = {blade_right[], blade_axis}; Plane Surface(1) = {1};
Curve Loop(2) = {blade_left[], blade_axis};  Plane Surface(2) = {2};
Curve Loop(3) = {disc_right[], more_right[], -disc_axis};  Plane Surface(3) = {3};
Curve Loop(4) = {disc_left[], more_left[], -disc_axis};   Plane Surface(4) = {4};
mirror[] = {-1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
Periodic Surface {2} = {1} Affine {mirror[]};
Periodic Surface {4} = {3} Affine {mirror[]};

Physical Surface("blade") = {1, 2};
Physical Surface("disc") = {3, 4};
Physical Curve("blade_top") = {blade_right[0], blade_left[0]};
Physical Curve("blade_flank_right") = {blade_right[{4 : 10}]};
Physical Curve("blade_flank_left") = {blade_left[{4 : 10}]};
Physical Curve("disc_flank_right") = {disc_right[{5 : 9}], more_right[]};
Physical Curve("disc_flank_left") = {disc_left[{5 : 9}], more_left[]};
Physical Curve("disc_side_right") = {disc_right[14]};
Physical Curve("disc_side_left") = {disc_left[14]};
Physical Curve("disc_bottom") = {disc_right[15], disc_left[15]};

// Element size: the distance is that from the nearer surface, so that both bodies are graded alike.
// Elements are not larger than the arcs beside them and the walls around them.
Field[1] = Distance;
Field[1].CurvesList = {blade_right[{fine[]}], blade_left[{fine[]}],
                       disc_right[{6, 8}], disc_left[{6, 8}], more_right[], more_left[]};
Field[1].Sampling = 100;
Field[2] = Distance;
Field[2].CurvesList = {blade_right[{4 : 10}], blade_left[{4 : 10}],
                       disc_right[{5 : 9}], disc_left[{5 : 9}], more_right[], more_left[]};
Field[2].Sampling = 200;
Field[3] = Distance;
Field[3].CurvesList = {blade_right[2], blade_left[2]};
Field[4] = Distance;
Field[4].CurvesList = {blade_right[13], blade_left[13]};
Field[5] = Distance;
Field[5].CurvesList = {disc_right[{1, 3}], disc_left[{1, 3}]};
Field[6] = Distance;
Field[6].CurvesList = {disc_right[11], disc_left[11]};
contact_size = Sprintf("Min(%g + %g*F1, %g + %g*F2)", edge_size, growth, flank_size, growth);
blade_size = Sprintf("Min(Min(%g + %g*F3, %g + %g*F4), %g)",
                     neck_fillet, growth, root_corner, growth, neck);
disc_size = Sprintf("Min(Min(%g + %g*F5, %g + %g*F6), %g)",
                    slot_fillet, growth, edge_radius, growth,
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

// SPDX-License-Identifier: LGPL-3.0-or-later
//
// A blade with a hammer-head root in one of `sectors` sectors of a disc, with a shim on each of its
// shoulders. Plane, symmetric about x = 0; the axis of the disc is at (0, -pitch_radius). Lengths in mm.
//
//      blade     |      disc          Both sides of a shim touch flats from inner to outer, which have
//                |  _____________     rounded ends of radius `round`: the blade's shoulder at y = 0
//      |         \_(_____________     and the disc's at y = shim.
//      |          ____shim____   |
//      |         _(__________)|  |    Element size: edge_size at the four ends of flats, flank_size along
//      |        (             |  |    the shims, and growing by `growth` per distance from there.
//
// Groups: blade, disc, shim_left, shim_right; blade_top, disc_side_left, disc_side_right, and for both
//         sides root_left, seat_left (of blade and disc), shim_left_inside, shim_left_outside.

sectors = 24; pitch_radius = 300; depth = 50;
inner = 8; outer = 12; round = 3; shim = 0.8; fillet = 1.2;
edge_size = 0.03; edge_zone = 0.15; flank_size = 0.15; growth = 0.4;

// From the end of a flat a rounding turns by 30 degrees, and a fillet turns back to a wall.
c = Cos(Pi / 6); s = Sin(Pi / 6);
relief_x = round * s; relief_y = round * (1 - c);
centre_x = (round + fillet) * s; centre_y = (round + fillet) * c - round;
half = Pi / sectors;
neck = inner - centre_x - fillet;
wall = outer + centre_x + fillet;
top = shim + round + 4; bottom = -9; slot = -10;
corner = (pitch_radius + top) * Tan(half);
bore = pitch_radius - depth;

Point(1) = {0, 35, 0}; Point(2) = {0, bottom, 0}; Point(3) = {0, slot, 0};
Point(4) = {0, -depth, 0}; Point(5) = {0, -pitch_radius, 0};
Line(1) = {2, 1}; Line(2) = {4, 3};
fine[] = {}; flanks[] = {}; tops[] = {};

For side In {1 : -1 : -2}
  // Half of the blade, from its top down.
  p = newp;
  Point(p) = {side * neck, 35, 0};
  Point(p + 1) = {side * neck, centre_y, 0};
  Point(p + 2) = {side * (inner - centre_x), centre_y, 0};
  Point(p + 3) = {side * (inner - relief_x), -relief_y, 0};
  Point(p + 4) = {side * inner, -round, 0};
  Point(p + 5) = {side * inner, 0, 0};
  Point(p + 6) = {side * outer, 0, 0};
  Point(p + 7) = {side * outer, -round, 0};
  Point(p + 8) = {side * (outer + relief_x), -relief_y, 0};
  Point(p + 9) = {side * (outer + round), -round, 0};
  Point(p + 10) = {side * (outer + round), bottom, 0};
  // Half of the disc, from the slot's mouth down.
  d = p + 11;
  Point(d) = {side * (inner - round), top, 0};
  Point(d + 1) = {side * (inner - round), shim + round, 0};
  Point(d + 2) = {side * inner, shim + round, 0};
  Point(d + 3) = {side * (inner - relief_x), shim + relief_y, 0};
  Point(d + 4) = {side * inner, shim, 0};
  Point(d + 5) = {side * outer, shim, 0};
  Point(d + 6) = {side * outer, shim + round, 0};
  Point(d + 7) = {side * (outer + relief_x), shim + relief_y, 0};
  Point(d + 8) = {side * (outer + centre_x), shim - centre_y, 0};
  Point(d + 9) = {side * wall, shim - centre_y, 0};
  Point(d + 10) = {side * wall, slot + 2, 0};
  Point(d + 11) = {side * (wall - 2), slot + 2, 0};
  Point(d + 12) = {side * (wall - 2), slot, 0};
  Point(d + 13) = {side * corner, top, 0};
  Point(d + 14) = {side * bore * Sin(half), bore * Cos(half) - pitch_radius, 0};
  // The shim, and where on it flats end.
  q = d + 15;
  Point(q) = {side * (inner - relief_x), 0, 0};
  Point(q + 1) = {side * (outer + relief_x), 0, 0};
  Point(q + 2) = {side * (outer + relief_x), shim, 0};
  Point(q + 3) = {side * (inner - relief_x), shim, 0};

  l = newc;
  Line(l) = {1, p}; Line(l + 1) = {p, p + 1};
  Circle(l + 2) = {p + 1, p + 2, p + 3};
  Circle(l + 3) = {p + 3, p + 4, p + 5};
  Line(l + 4) = {p + 5, p + 6};
  Circle(l + 5) = {p + 6, p + 7, p + 8};
  Circle(l + 6) = {p + 8, p + 7, p + 9};
  Line(l + 7) = {p + 9, p + 10}; Line(l + 8) = {p + 10, 2};
  m = l + 9;
  Line(m) = {d, d + 1};
  Circle(m + 1) = {d + 1, d + 2, d + 3};
  Circle(m + 2) = {d + 3, d + 2, d + 4};
  Line(m + 3) = {d + 4, d + 5};
  Circle(m + 4) = {d + 5, d + 6, d + 7};
  Circle(m + 5) = {d + 7, d + 8, d + 9};
  Line(m + 6) = {d + 9, d + 10};
  Circle(m + 7) = {d + 10, d + 11, d + 12};
  Line(m + 8) = {d + 12, 3};
  Circle(m + 9) = {4, 5, d + 14};
  Line(m + 10) = {d + 14, d + 13}; Line(m + 11) = {d + 13, d};
  n = m + 12;
  Line(n) = {q, q + 1}; Line(n + 1) = {q + 1, q + 2};
  Line(n + 2) = {q + 2, q + 3}; Line(n + 3) = {q + 3, q};

  k = side > 0 ? 0 : 3;
  Curve Loop(k + 1) = {l : l + 8, 1}; Plane Surface(k + 1) = {k + 1};
  Curve Loop(k + 2) = {m : m + 8, -2, m + 9, m + 10, m + 11}; Plane Surface(k + 2) = {k + 2};
  Curve Loop(k + 3) = {n : n + 3}; Plane Surface(k + 3) = {k + 3};
  fine[] += {p + 5, p + 6, d + 4, d + 5};
  flanks[] += {n, n + 2};
  name = StrChoice(side > 0, "right", "left");
  Physical Surface(StrCat("shim_", name)) = {k + 3};
  Physical Curve(StrCat("root_", name)) = {l + 3, l + 4, l + 5};
  Physical Curve(StrCat("seat_", name)) = {m + 2, m + 3, m + 4};
  Physical Curve(StrCat("shim_", name, "_inside")) = {n};
  Physical Curve(StrCat("shim_", name, "_outside")) = {n + 2};
  Physical Curve(StrCat("disc_side_", name)) = {m + 10};
  tops[] += {l};
EndFor

Physical Curve("blade_top") = {tops[]};
Physical Surface("blade") = {1, 4};
Physical Surface("disc") = {2, 5};
mirror[] = {-1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
Periodic Surface {4} = {1} Affine {mirror[]};
Periodic Surface {5} = {2} Affine {mirror[]};
Periodic Surface {6} = {3} Affine {mirror[]};

Field[1] = Distance;
Field[1].PointsList = {fine[]};
Field[2] = Distance;
Field[2].CurvesList = {flanks[]};
Field[2].Sampling = 200;
Field[3] = MathEval;
Field[3].F = Sprintf("Min(%g + %g * Max(F1 - %g, 0), %g + %g * F2)", edge_size, growth, edge_zone, flank_size, growth);
Background Field = 3;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 6;

// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Flat and rounded punch: an upper body whose lower face is flat in the middle and rounded at both
// ends, on a flat block. Plane, symmetric about x = 0; the flat lies on the block at the start.
// Lengths in mm.
//
//              upper_top
//      +-----------+-----------+ ^          The upper body is a block, upper_height high and
//      |         upper         | |          2 upper_width wide. Its lower face is flat where
//      |           |           | |          |x| <= flat_half_width; from there arcs of `radius`,
//      |           |           | | upper_height    tangent to the flat, lead to the sides. The
//       \          |          /  |          initial gap is 0 on the flat, beside it nearly
//        \_        |        _/   |          (|x| - flat_half_width)^2 / (2 radius).
//     +----\_______|_______/----+v
//     |            <flat->      | ^         The candidate contact surfaces are the part of both
//     |            <--zone-->   | |         faces with |x| <= zone; the contact must end on the
//     |            |            | |         roundings, between flat_half_width and zone.
//     |          lower          | | lower_height
//     |            |            | |
//     +------------+------------+ v
//             lower_bottom
//                  <lower_width->
//
// Element size: edge_size on the roundings as far as zone and on the ends of the flat (half as long
// as the roundings there, at most half of the flat); from there it grows by `growth` per distance,
// on the flat to no more than flat_size. The lower body is meshed 7 % coarser, so the meshes do not
// match. The left half of the mesh mirrors the right half.
//
// Groups: upper, lower; upper_contact, upper_top, lower_contact, lower_bottom, lower_left,
//         lower_right.

DefineConstant[
  flat_half_width = {1,     Min 1e-3, Max 1e3, Name "Parameters/01 Half of the width of the flat [mm]"},
  radius          = {8,     Min 1e-2, Max 1e4, Name "Parameters/02 Radius of the rounded ends [mm]"},
  upper_width     = {8,     Min 0.01, Max 1e4, Name "Parameters/03 Half of the width of the upper body [mm]"},
  upper_height    = {12,    Min 0.01, Max 1e4, Name "Parameters/04 Height of the upper body [mm]"},
  lower_width     = {10,    Min 0.01, Max 1e4, Name "Parameters/05 Half of the width of the lower body [mm]"},
  lower_height    = {12,    Min 0.01, Max 1e4, Name "Parameters/06 Height of the lower body [mm]"},
  zone            = {1.4,   Min 1e-3, Max 1e3, Name "Parameters/07 Half of the width of the candidate contact zone [mm]"},
  edge_size       = {0.005, Min 1e-5, Max 1e2, Name "Parameters/08 Element size on the roundings in the contact zone [mm]"},
  flat_size       = {0.05,  Min 1e-5, Max 1e2, Name "Parameters/09 Element size in the middle of the flat [mm]"},
  growth          = {0.15,  Min 0.02, Max 0.5, Name "Parameters/10 Growth of the element size per distance from the fine mesh [-]"}
];

// What the parameters must satisfy together; a message begins with the name of its parameter.
wrong = 0;
least = (upper_width - flat_half_width) / 0.99;
If (radius < least)
  Error("radius: expected at least %.6g (the roundings must reach the sides of the upper body; a smaller upper_width helps), found %g", least, radius); wrong = 1;
EndIf
most = 0.9 * Min(upper_width, lower_width);
If (zone > most)
  Error("zone: expected at most %.6g (nine tenths of the smaller of the half widths), found %g", most, zone); wrong = 1;
EndIf
least = flat_half_width + 4 * edge_size;
If (zone < least)
  Error("zone: expected at least %.6g (the contact ends beyond flat_half_width; four elements of edge_size must fit in there), found %g", least, zone); wrong = 1;
EndIf
// A face that is too steep is to be mended first, and rises less then.
round = Max(radius, (upper_width - flat_half_width) / 0.99);
rise = round - Sqrt(round^2 - (upper_width - flat_half_width)^2);
least = rise + 0.1 * upper_width;
If (upper_height < least)
  Error("upper_height: expected at least %.6g (the face rises by %.6g and the body needs a side), found %g", least, rise, upper_height); wrong = 1;
EndIf
least = 0.1 * lower_width;
If (lower_height < least)
  Error("lower_height: expected at least %.6g (the body needs a side), found %g", least, lower_height); wrong = 1;
EndIf
most = flat_half_width / 2;
If (flat_size > most)
  Error("flat_size: expected at most %.6g (half of flat_half_width), found %g", most, flat_size); wrong = 1;
EndIf
most = flat_size;
If (edge_size > most)
  Error("edge_size: expected at most %.6g (flat_size), found %g", most, edge_size); wrong = 1;
EndIf

// Everything from here to the end of the file is drawn only if nothing is wrong.
If (!wrong)

fine = Max(flat_half_width - (zone - flat_half_width) / 2, flat_half_width / 2);

// Curves of a half body run from the origin along the face to the far end and back to the axis of
// symmetry; up is 1 (upper body) or -1 (lower body), side is 1 (right) or -1 (left).
halves[] = {};
axes[] = {};
walls[] = {};
For up In {1 : -1 : -2}
  If (up > 0)
    width = upper_width;
    height = upper_height;
    zone_y = radius - Sqrt(radius^2 - (zone - flat_half_width)^2);
    face_y = radius - Sqrt(radius^2 - (width - flat_half_width)^2);
  Else
    width = lower_width;
    height = lower_height;
    zone_y = 0;
    face_y = 0;
  EndIf
  axis_face = newp; Point(axis_face) = {0, 0, 0};
  axis_end = newp; Point(axis_end) = {0, up * height, 0};
  axis = newc; Line(axis) = {axis_end, axis_face};
  For side In {1 : -1 : -2}
    p = newp;
    Point(p)     = {side * fine, 0, 0};
    Point(p + 1) = {side * flat_half_width, 0, 0};
    Point(p + 2) = {side * zone, zone_y, 0};
    Point(p + 3) = {side * width, face_y, 0};
    Point(p + 4) = {side * width, up * height, 0};
    c = newc;
    walls[] += {Min(width, height - face_y)};
    Line(c)      = {axis_face, p};
    Line(c + 1)  = {p, p + 1};
    If (up > 0)
      centre = p + 5;
      Point(centre) = {side * flat_half_width, radius, 0};
      Circle(c + 2) = {p + 1, centre, p + 2};
      Circle(c + 3) = {p + 2, centre, p + 3};
    Else
      Line(c + 2)   = {p + 1, p + 2};
      Line(c + 3)   = {p + 2, p + 3};
    EndIf
    Line(c + 4)  = {p + 3, p + 4};
    Line(c + 5)  = {p + 4, axis_end};
    halves[] += {c : c + 5};
  EndFor
  axes[] += {axis};
EndFor
upper_right[] = halves[{0 : 5}];
upper_left[] = halves[{6 : 11}];
lower_right[] = halves[{12 : 17}];
lower_left[] = halves[{18 : 23}];

Curve Loop(1) = {upper_right[], axes[0]}; Plane Surface(1) = {1};
Curve Loop(2) = {upper_left[], axes[0]};  Plane Surface(2) = {2};
Curve Loop(3) = {lower_right[], axes[1]}; Plane Surface(3) = {3};
Curve Loop(4) = {lower_left[], axes[1]};  Plane Surface(4) = {4};
mirror[] = {-1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
Periodic Surface {2} = {1} Affine {mirror[]};
Periodic Surface {4} = {3} Affine {mirror[]};

Physical Surface("upper") = {1, 2};
Physical Surface("lower") = {3, 4};
Physical Curve("upper_contact") = {upper_right[{0 : 2}], upper_left[{0 : 2}]};
Physical Curve("upper_top") = {upper_right[5], upper_left[5]};
Physical Curve("lower_contact") = {lower_right[{0 : 2}], lower_left[{0 : 2}]};
Physical Curve("lower_bottom") = {lower_right[5], lower_left[5]};
Physical Curve("lower_right") = {lower_right[4]};
Physical Curve("lower_left") = {lower_left[4]};

// Element size: the distances are those from the nearer face, so that both bodies are graded alike.
// Elements are not larger than half of the width of a body and than its sides.
Field[1] = Distance;
Field[1].CurvesList = {upper_right[{1, 2}], upper_left[{1, 2}],
                       lower_right[{1, 2}], lower_left[{1, 2}]};
Field[1].Sampling = 200;
Field[2] = Distance;
Field[2].CurvesList = {upper_right[0], upper_left[0], lower_right[0], lower_left[0]};
Field[2].Sampling = 200;
Field[3] = MathEval;
Field[3].F = Sprintf("Min(Min(%g + %g*F1, %g + %g*F2), %g)",
                     edge_size, growth, flat_size, growth, walls[0]);
Field[4] = Restrict;
Field[4].InField = 3;
Field[4].SurfacesList = {1, 2};
Field[5] = MathEval;
Field[5].F = Sprintf("1.07 * Min(Min(%g + %g*F1, %g + %g*F2), %g)",
                     edge_size, growth, flat_size, growth, walls[2]);
Field[6] = Restrict;
Field[6].InField = 5;
Field[6].SurfacesList = {3, 4};
Field[7] = Min;
Field[7].FieldsList = {4, 6};
Background Field = 7;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 6;

EndIf

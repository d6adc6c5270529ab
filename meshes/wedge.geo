// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Wedge: an upper body whose lower face is a shallow wedge, on a flat block. Plane, symmetric about
// x = 0; the apex of the wedge touches the block in the origin. Lengths in mm.
//
//              upper_top
//      +-----------+-----------+ ^          The upper body is a block, upper_height high above
//      |         upper         | |          the apex and 2 upper_width wide. Its lower face rises
//      |           |           | |          by `angle` to either side, so that the initial gap is
//      |           |           | | upper_height    Tan(angle) |x|. The wider and higher the
//      |_          |          _| |          bodies are in comparison with the contact, the nearer
//        --__      |      __--   |          they come to half-planes.
//            --__  |  __--  angle|
//     +----------__|__----------+v          The candidate contact surfaces are the part of both
//     |            <--zone-->   | ^         faces with |x| <= zone, meshed evenly with elements
//     |          lower          | |         of `size`; from there the size grows by `growth` per
//     |            |            | | lower_height    distance. The lower body is meshed 7 %
//     |            |            | |         coarser, so the meshes do not match. The left half of
//     +------------+------------+ v         the mesh mirrors the right half.
//             lower_bottom
//                  <lower_width->
//
// Groups: upper, lower; upper_contact, upper_top, lower_contact, lower_bottom, lower_left,
//         lower_right.

DefineConstant[
  angle        = {2,    Min 0.05, Max 20,  Name "Parameters/01 Angle between the two faces on either side of the apex [degrees]"},
  upper_width  = {8,    Min 0.01, Max 1e4, Name "Parameters/02 Half of the width of the upper body [mm]"},
  upper_height = {10,   Min 0.01, Max 1e4, Name "Parameters/03 Height of the upper body above the apex [mm]"},
  lower_width  = {10,   Min 0.01, Max 1e4, Name "Parameters/04 Half of the width of the lower body [mm]"},
  lower_height = {10,   Min 0.01, Max 1e4, Name "Parameters/05 Height of the lower body [mm]"},
  zone         = {1,    Min 1e-3, Max 1e3, Name "Parameters/06 Half of the width of the candidate contact zone [mm]"},
  size         = {0.01, Min 1e-5, Max 1e2, Name "Parameters/07 Element size in the contact zone [mm]"},
  growth       = {0.15, Min 0.02, Max 0.5, Name "Parameters/08 Growth of the element size per distance from the contact zone [-]"}
];

// What the parameters must satisfy together; a message begins with the name of its parameter.
wrong = 0;
most = 0.9 * Min(upper_width, lower_width);
If (zone > most)
  Error("zone: expected at most %.6g (nine tenths of the smaller of the half widths), found %g", most, zone); wrong = 1;
EndIf
rise = upper_width * Tan(angle * Pi / 180);
least = rise + 0.1 * upper_width;
If (upper_height < least)
  Error("upper_height: expected at least %.6g (the face rises by %.6g and the body needs a side), found %g", least, rise, upper_height); wrong = 1;
EndIf
least = 0.1 * lower_width;
If (lower_height < least)
  Error("lower_height: expected at least %.6g (the body needs a side), found %g", least, lower_height); wrong = 1;
EndIf
most = zone / 4;
If (size > most)
  Error("size: expected at most %.6g (a quarter of zone), found %g", most, size); wrong = 1;
EndIf

// Everything from here to the end of the file is drawn only if nothing is wrong.
If (!wrong)

// Curves of a half body run from the origin along the face to the far end and back to the axis of
// symmetry; up is 1 (upper body) or -1 (lower body), side is 1 (right) or -1 (left).
halves[] = {};
axes[] = {};
walls[] = {};
For up In {1 : -1 : -2}
  If (up > 0)
    slope = Tan(angle * Pi / 180);
    width = upper_width;
    height = upper_height;
  Else
    slope = 0;
    width = lower_width;
    height = lower_height;
  EndIf
  axis_face = newp; Point(axis_face) = {0, 0, 0};
  axis_end = newp; Point(axis_end) = {0, up * height, 0};
  axis = newc; Line(axis) = {axis_end, axis_face};
  For side In {1 : -1 : -2}
    p = newp;
    Point(p)     = {side * zone, slope * zone, 0};
    Point(p + 1) = {side * width, slope * width, 0};
    Point(p + 2) = {side * width, up * height, 0};
    c = newc;
    walls[] += {Min(width, height - slope * width)};
    Line(c)      = {axis_face, p};
    Line(c + 1)  = {p, p + 1};
    Line(c + 2)  = {p + 1, p + 2};
    Line(c + 3)  = {p + 2, axis_end};
    halves[] += {c : c + 3};
  EndFor
  axes[] += {axis};
EndFor
upper_right[] = halves[{0 : 3}];
upper_left[] = halves[{4 : 7}];
lower_right[] = halves[{8 : 11}];
lower_left[] = halves[{12 : 15}];

Curve Loop(1) = {upper_right[], axes[0]}; Plane Surface(1) = {1};
Curve Loop(2) = {upper_left[], axes[0]};  Plane Surface(2) = {2};
Curve Loop(3) = {lower_right[], axes[1]}; Plane Surface(3) = {3};
Curve Loop(4) = {lower_left[], axes[1]};  Plane Surface(4) = {4};
mirror[] = {-1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1};
Periodic Surface {2} = {1} Affine {mirror[]};
Periodic Surface {4} = {3} Affine {mirror[]};

Physical Surface("upper") = {1, 2};
Physical Surface("lower") = {3, 4};
Physical Curve("upper_contact") = {upper_right[0], upper_left[0]};
Physical Curve("upper_top") = {upper_right[3], upper_left[3]};
Physical Curve("lower_contact") = {lower_right[0], lower_left[0]};
Physical Curve("lower_bottom") = {lower_right[3], lower_left[3]};
Physical Curve("lower_right") = {lower_right[2]};
Physical Curve("lower_left") = {lower_left[2]};

// Element size: the distance is that from the nearer face, so that both bodies are graded alike.
// Elements are not larger than half of the width of a body and than its sides.
Field[1] = Distance;
Field[1].CurvesList = {upper_right[0], upper_left[0], lower_right[0], lower_left[0]};
Field[1].Sampling = 400;
Field[2] = MathEval;
Field[2].F = Sprintf("Min(%g + %g*F1, %g)", size, growth, walls[0]);
Field[3] = Restrict;
Field[3].InField = 2;
Field[3].SurfacesList = {1, 2};
Field[4] = MathEval;
Field[4].F = Sprintf("1.07 * Min(%g + %g*F1, %g)", size, growth, walls[2]);
Field[5] = Restrict;
Field[5].InField = 4;
Field[5].SurfacesList = {3, 4};
Field[6] = Min;
Field[6].FieldsList = {3, 5};
Background Field = 6;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 6;

EndIf

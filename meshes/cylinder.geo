// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Cylinder: an upper body with a cylindrical face on a lower one, which is a second cylinder or, with
// lower_radius = 0, a flat block. Plane, symmetric about x = 0; the bodies touch in the origin.
// Lengths in mm.
//
//              upper_top
//      +-----------+-----------+ ^          The upper body is a block, upper_height high and
//      |         upper         | |          2 upper_width wide, whose lower face is rounded with
//      |           |           | |          upper_radius; the lower body likewise. The wider and
//      |           |           | |          higher the bodies are in comparison with the contact,
//       \_         |         _/  |          the nearer they come to half-planes.
//         \_       |       _/    | upper_height
//           \__    |    __/      |          The candidate contact surfaces are the part of both
//        ______\___|___/______   v          faces with |x| <= zone, meshed evenly with elements
//      _/     <--zone-->      \_            of `size`; from there the size grows by `growth` per
//     |            |            | ^         distance. The lower body is meshed 7 % coarser, so the
//     |          lower          | |         meshes do not match. The left half of the mesh mirrors
//     |            |            | | lower_height    the right half.
//     +------------+------------+ v
//             lower_bottom
//                  <lower_width->
//
// Groups: upper, lower; upper_contact, upper_top, lower_contact, lower_bottom, lower_left,
//         lower_right.

DefineConstant[
  upper_radius = {8,    Min 0.1,  Max 1e4, Name "Parameters/01 Radius of the upper face [mm]"},
  upper_width  = {7,    Min 0.01, Max 1e4, Name "Parameters/02 Half of the width of the upper body [mm]"},
  upper_height = {12,   Min 0.01, Max 1e4, Name "Parameters/03 Height of the upper body [mm]"},
  lower_radius = {8,    Min 0,    Max 1e4, Name "Parameters/04 Radius of the lower face, 0 for a flat block [mm]"},
  lower_width  = {7,    Min 0.01, Max 1e4, Name "Parameters/05 Half of the width of the lower body [mm]"},
  lower_height = {12,   Min 0.01, Max 1e4, Name "Parameters/06 Height of the lower body [mm]"},
  zone         = {1,    Min 1e-3, Max 1e3, Name "Parameters/07 Half of the width of the candidate contact zone [mm]"},
  size         = {0.01, Min 1e-5, Max 1e2, Name "Parameters/08 Element size in the contact zone [mm]"},
  growth       = {0.15, Min 0.02, Max 0.5, Name "Parameters/09 Growth of the element size per distance from the contact zone [-]"}
];

// What the parameters must satisfy together; a message begins with the name of its parameter.
wrong = 0;
most = 0.99 * upper_radius;
If (upper_width > most)
  Error("upper_width: expected at most %.6g (upper_radius), found %g", most, upper_width); wrong = 1;
EndIf
most = 0.99 * lower_radius;
If (lower_radius > 0 && lower_width > most)
  Error("lower_width: expected at most %.6g (lower_radius), found %g", most, lower_width); wrong = 1;
EndIf
most = 0.9 * Min(upper_width, lower_width);
If (zone > most)
  Error("zone: expected at most %.6g (nine tenths of the smaller of the half widths), found %g", most, zone); wrong = 1;
EndIf
// A face that is too steep is to be mended first, and rises less then.
width = Min(upper_width, 0.99 * upper_radius);
rise = upper_radius - Sqrt(upper_radius^2 - width^2);
least = rise + 0.1 * width;
If (upper_height < least)
  Error("upper_height: expected at least %.6g (the face rises by %.6g and the body needs a side), found %g", least, rise, upper_height); wrong = 1;
EndIf
width = lower_radius > 0 ? Min(lower_width, 0.99 * lower_radius) : lower_width;
rise = lower_radius - Sqrt(Max(lower_radius^2 - width^2, 0));
least = rise + 0.1 * width;
If (lower_height < least)
  Error("lower_height: expected at least %.6g (the face rises by %.6g and the body needs a side), found %g", least, rise, lower_height); wrong = 1;
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
    radius = upper_radius;
    width = upper_width;
    height = upper_height;
  Else
    radius = lower_radius;
    width = lower_width;
    height = lower_height;
  EndIf
  axis_face = newp; Point(axis_face) = {0, 0, 0};
  axis_end = newp; Point(axis_end) = {0, up * height, 0};
  axis = newc; Line(axis) = {axis_end, axis_face};
  For side In {1 : -1 : -2}
    p = newp;
    If (radius > 0)
      centre = p;
      Point(p)   = {0, up * radius, 0};
      zone_y = up * (radius - Sqrt(radius^2 - zone^2));
      face_y = up * (radius - Sqrt(radius^2 - width^2));
    Else
      zone_y = 0;
      face_y = 0;
    EndIf
    Point(p + 1) = {side * zone, zone_y, 0};
    Point(p + 2) = {side * width, face_y, 0};
    Point(p + 3) = {side * width, up * height, 0};
    c = newc;
    walls[] += {Min(width, height - Fabs(face_y))};
    If (radius > 0)
      Circle(c)     = {axis_face, centre, p + 1};
      Circle(c + 1) = {p + 1, centre, p + 2};
    Else
      Line(c)       = {axis_face, p + 1};
      Line(c + 1)   = {p + 1, p + 2};
    EndIf
    Line(c + 2)     = {p + 2, p + 3};
    Line(c + 3)     = {p + 3, axis_end};
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

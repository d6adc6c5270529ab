// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Sphere: an upper body with a spherical or ellipsoidal face on a lower one, which is a second sphere
// or, with lower_radius = 0, a flat block. Solid; the bodies touch in the origin. Lengths in mm.
//
//       y            upper_top
//       |      +-----------+-----------+ ^          The upper body is a block, upper_height high,
//       o--x   |         upper         | |          2 upper_width wide in x and in z, whose lower
//      /       |           |           | |          face is rounded with radius_x in the plane of
//     z         \_         |         _/  |          x and y and with radius_z in that of z and y;
//                 \_       |       _/    | upper_height     the lower body likewise, with one radius.
//                   \__    |    __/      |          With bodies 20 contacts wide and high half-
//        ______________\___|___/______   v          spaces are about 2 % stiffer or softer.
//       |           <-zone->          |  ^
//       |            |                |  |          Expected is contact on the ellipse with the half
//       |          lower              |  |          axes contact_x and contact_z. Elements have
//       |            |                |  | lower_height     `size` out to 1.3 times that ellipse, from
//       +------------+----------------+  v          where it grows by `growth` per distance. The
//             lower_bottom                          candidate contact surfaces are rectangles of
//                    <--lower_width-->              `zone` times the contact. The lower body is
//                                                   meshed 7 % coarser: the meshes do not match.
//
// Groups: upper, lower; upper_contact, upper_top, upper_left, upper_right, upper_back, upper_front,
//         lower_contact, lower_bottom, lower_left, lower_right, lower_back, lower_front.

DefineConstant[
  radius_x     = {50,   Min 0.1,  Max 1e4, Name "Parameters/01 Radius of the upper face in x [mm]"},
  radius_z     = {0,    Min 0,    Max 1e4, Name "Parameters/02 Radius of the upper face in z, 0 for that in x [mm]"},
  lower_radius = {0,    Min 0,    Max 1e4, Name "Parameters/03 Radius of the lower face, 0 for a flat block [mm]"},
  upper_width  = {20,   Min 0.01, Max 1e4, Name "Parameters/04 Half of the width of the upper body [mm]"},
  upper_height = {20,   Min 0.01, Max 1e4, Name "Parameters/05 Height of the upper body [mm]"},
  lower_width  = {20,   Min 0.01, Max 1e4, Name "Parameters/06 Half of the width of the lower body [mm]"},
  lower_height = {20,   Min 0.01, Max 1e4, Name "Parameters/07 Height of the lower body [mm]"},
  contact_x    = {1,    Min 1e-4, Max 1e3, Name "Parameters/08 Expected half width of the contact in x [mm]"},
  contact_z    = {0,    Min 0,    Max 1e3, Name "Parameters/09 Expected half width of the contact in z, 0 for that in x [mm]"},
  zone         = {1.6,  Min 1.5,  Max 10,  Name "Parameters/10 Candidate contact zone, in half widths of the expected contact [-]"},
  size         = {0.085,Min 1e-5, Max 1e2, Name "Parameters/11 Element size in the expected contact [mm]"},
  growth       = {0.35, Min 0.05, Max 0.7, Name "Parameters/12 Growth of the element size per distance from the contact [-]"}
];

// Radii and half widths of the contact that follow those in x.
rz = radius_z > 0 ? radius_z : radius_x;
cz = contact_z > 0 ? contact_z : contact_x;

// What the parameters must satisfy together; a message begins with the name of its parameter.
// The face must not become vertical at the corners of the body.
wrong = 0;
upper_most = 0.85 / Sqrt(1 / (radius_x * Min(radius_x, rz)) + 1 / (rz * Min(radius_x, rz)));
If (upper_width > upper_most)
  Error("upper_width: expected at most %.6g (the face would be too steep at the corners of the body), found %g", upper_most, upper_width); wrong = 1;
EndIf
lower_most = lower_radius > 0 ? 0.85 * lower_radius / Sqrt(2) : lower_width;
If (lower_width > lower_most)
  Error("lower_width: expected at most %.6g (the face would be too steep at the corners of the body), found %g", lower_most, lower_width); wrong = 1;
EndIf
most = 0.9 * Min(upper_width, lower_width) / zone;
If (contact_x > most)
  Error("contact_x: expected at most %.6g (nine tenths of the smaller of the half widths, over zone), found %g", most, contact_x); wrong = 1;
EndIf
If (cz > most)
  Error("contact_z: expected at most %.6g (nine tenths of the smaller of the half widths, over zone), found %g", most, cz); wrong = 1;
EndIf
most = Min(contact_x, cz) / 2;
If (size > most)
  Error("size: expected at most %.6g (half of the smaller half width of the contact), found %g", most, size); wrong = 1;
EndIf
// 200 elements over the half width are half a million triangles on a face, millions of cells beneath.
least = Min(contact_x, cz) / 200;
If (size < least)
  Error("size: expected at least %.6g (200 elements over the smaller half width of the contact), found %g", least, size); wrong = 1;
EndIf
For up In {1 : -1 : -2}
  flat = (up < 0 && lower_radius == 0);
  rx = (up > 0) ? radius_x : lower_radius;
  r = (up > 0) ? rz : lower_radius;
  // A face that is too wide is to be narrower first, and rises less then.
  width = (up > 0) ? Min(upper_width, upper_most) : Min(lower_width, lower_most);
  height = (up > 0) ? upper_height : lower_height;
  rise = 0;
  If (!flat)
    half = Min(rx, r);
    rise = half * (1 - Sqrt(Max(1 - width^2 / (rx * half) - width^2 / (r * half), 0)));
  EndIf
  least = Max(rise, zone * Min(contact_x, cz)) + 0.1 * width;
  If (height < least && up > 0)
    Error("upper_height: expected at least %.6g (the face rises by %.6g, and the fine zone and a side need room), found %g", least, rise, height); wrong = 1;
  EndIf
  If (height < least && up < 0)
    Error("lower_height: expected at least %.6g (the face rises by %.6g, and the fine zone and a side need room), found %g", least, rise, height); wrong = 1;
  EndIf
EndFor

// Everything from here to the end of the file is drawn only if nothing is wrong.
If (!wrong)

SetFactory("OpenCASCADE");

// Each body is a block without what lies beyond the ellipsoid that its face is a part of. Cuts
// around the candidate contact divide it in two parts that share nodes: the inner one is a block too.
deep = zone * Min(contact_x, cz);
For up In {1 : -1 : -2}
  flat = (up < 0 && lower_radius == 0);
  rx = (up > 0) ? radius_x : lower_radius;
  r = (up > 0) ? rz : lower_radius;
  width = (up > 0) ? upper_width : lower_width;
  height = (up > 0) ? upper_height : lower_height;
  body = newv;
  Box(body) = {-width, Min(0, up * height), -width, 2 * width, height, 2 * width};
  If (!flat)
    // half axes such that the radii of curvature at the origin are rx and r
    half = Min(rx, r);
    ax = Sqrt(rx * half);
    az = Sqrt(r * half);
    ball = newv;
    Sphere(ball) = {0, up * half, 0, half};
    If (ax > half || az > half)
      Dilate {{0, up * half, 0}, {ax / half, 1, az / half}} { Volume{ball}; }
    EndIf
    beyond = newv;
    below = (up > 0) ? -0.1 * half : -half;
    Box(beyond) = {-1.05 * width, below, -1.05 * width, 2.1 * width, 1.1 * half, 2.1 * width};
    rest[] = BooleanDifference{ Volume{beyond}; Delete; }{ Volume{ball}; Delete; };
    whole[] = BooleanDifference{ Volume{body}; Delete; }{ Volume{rest[]}; Delete; };
    body = whole[0];
  EndIf
  inner = newv;
  Box(inner) = {-zone * contact_x, -deep, -zone * cz, 2 * zone * contact_x, 2 * deep, 2 * zone * cz};
  near[] = BooleanIntersection{ Volume{body}; }{ Volume{inner}; Delete; };
  both[] = BooleanFragments{ Volume{body}; Delete; }{ Volume{near[]}; Delete; };

  // Faces by their place: sides, end, and the two that are left, of which the candidate contact has
  // four curves. OpenCASCADE's boxes around curved faces are wide, and not exact for plane ones next to
  // them; cuts are a tenth of the width away from the sides. The upper body is not below y = tiny.
  tiny = 0.01 * width;
  far = 4 * (width + height);
  top = (up > 0) ? far : tiny;
  left[] = Surface In BoundingBox {-width - tiny, -far, -far, -width + tiny, top, far};
  right[] = Surface In BoundingBox {width - tiny, -far, -far, width + tiny, top, far};
  back[] = Surface In BoundingBox {-far, -far, -width - tiny, far, top, -width + tiny};
  front[] = Surface In BoundingBox {-far, -far, width - tiny, far, top, width + tiny};
  end[] = Surface In BoundingBox {-far, up * height - tiny, -far, far, up * height + tiny, far};
  touching[] = Abs(CombinedBoundary{ Volume{both[]}; });
  touching[] -= {left[], right[], back[], front[], end[]};
  curves[] = Boundary{ Surface{touching[0]}; };
  contact = (#curves[] == 4) ? touching[0] : touching[1];
  If (up > 0)
    body_name = "upper";
    Physical Surface("upper_top") = {end[]};
  Else
    body_name = "lower";
    Physical Surface("lower_bottom") = {end[]};
  EndIf
  Physical Volume(StrCat(body_name, "")) = {both[]};
  Physical Surface(StrCat(body_name, "_contact")) = {contact};
  Physical Surface(StrCat(body_name, "_left")) = {left[]};
  Physical Surface(StrCat(body_name, "_right")) = {right[]};
  Physical Surface(StrCat(body_name, "_back")) = {back[]};
  Physical Surface(StrCat(body_name, "_front")) = {front[]};

  // Element size: the distance is that from the ellipse with fine elements in the plane y = 0.
  // Elements are not larger than half of the half width of a body.
  small = Min(contact_x, cz);
  coarser = (up > 0) ? 1 : 1.07;
  f = (up > 0) ? 1 : 3;
  Field[f] = MathEval;
  Field[f].F = Sprintf("%g * Min(%g + %g * Sqrt((Max(Sqrt((x/%g)^2 + (z/%g)^2) - 1.3, 0) * %g)^2 + y^2), %g)",
    coarser, size, growth, contact_x, cz, small, width / 2);
  Field[f + 1] = Restrict;
  Field[f + 1].InField = f;
  Field[f + 1].VolumesList = {both[]};
EndFor
Field[5] = Min;
Field[5].FieldsList = {2, 4};
Background Field = 5;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 6;
Mesh.Algorithm3D = 1;
Mesh.OptimizeThreshold = 0.4;

EndIf

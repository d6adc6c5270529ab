// SPDX-License-Identifier: LGPL-3.0-or-later
//
// Finite cylinder: an upper body with a cylindrical face and free ends on a longer block. Solid, uniform
// along z between the ends; the bodies touch along the z axis. Lengths in mm.
//
//       y          upper_top                                    upper_top
//       |  +-----------+-----------+ ^                      +-----------------+
//       o--x           |upper      | |                      |      upper      |
//      /   |           |           | |                      |                 |
//     z     \_         |         _/  |          upper_back  |                 |  upper_front
//             \_       |       _/    | upper_height         |                 |
//               \__    |    __/      |                      |                 |
//    ______________\___|___/______   v       _______________|_____ length ____|________________
//   |              <zone->        |  ^      |               |                 |<- overhang --->|
//   |              |              |  |      | lower_back                           lower_front |
//   |            lower            |  | lower_height                 lower                      |
//   |              |              |  |      |                                                  |
//   +--------------+--------------+  v      +--------------------------------------------------+
//           lower_bottom
//                  <-lower_width->
//
// The candidate contact surfaces are the part of both faces with |x| <= zone, as long as the upper body.
// In sections they are meshed with elements of `size`, which grows by `growth` per distance; sections are
// swept along z in layers, of thickness end_size at the ends, growing by `growth` to length_size. The
// sections of the lower body are meshed 7 % coarser, and its layers are 1.1 times as thick: the meshes
// do not match. Without overhang both bodies end in the same planes.
//
// Groups: upper, lower; upper_contact, upper_top, upper_back, upper_front,
//         lower_contact, lower_bottom, lower_left, lower_right, lower_back, lower_front.

DefineConstant[
  radius       = {30,   Min 0.1,  Max 1e4, Name "Parameters/01 Radius of the upper face [mm]"},
  length       = {10,   Min 0.01, Max 1e4, Name "Parameters/02 Length of the upper body in z [mm]"},
  overhang     = {5,    Min 0,    Max 1e4, Name "Parameters/03 Length of the lower body beyond each end of the upper one [mm]"},
  upper_width  = {10,   Min 0.01, Max 1e4, Name "Parameters/04 Half of the width of the upper body [mm]"},
  upper_height = {10,   Min 0.01, Max 1e4, Name "Parameters/05 Height of the upper body [mm]"},
  lower_width  = {10,   Min 0.01, Max 1e4, Name "Parameters/06 Half of the width of the lower body [mm]"},
  lower_height = {10,   Min 0.01, Max 1e4, Name "Parameters/07 Height of the lower body [mm]"},
  zone         = {1.5,  Min 1e-3, Max 1e3, Name "Parameters/08 Half of the width of the candidate contact zone [mm]"},
  size         = {0.12, Min 1e-5, Max 1e2, Name "Parameters/09 Element size in the contact zone, in sections [mm]"},
  end_size     = {0.25, Min 1e-5, Max 1e2, Name "Parameters/10 Thickness of the layers at the ends of the contact [mm]"},
  length_size  = {1.5,  Min 1e-5, Max 1e3, Name "Parameters/11 Largest thickness of the layers [mm]"},
  growth       = {0.4,  Min 0.05, Max 0.7, Name "Parameters/12 Growth of sizes per distance from the contact and from its ends [-]"}
];

// What the parameters must satisfy together; a message begins with the name of its parameter.
wrong = 0;
most = 0.9 * radius;
If (upper_width > most)
  Error("upper_width: expected at most %.6g (nine tenths of radius), found %g", most, upper_width); wrong = 1;
EndIf
most = 0.9 * Min(upper_width, lower_width);
If (zone > most)
  Error("zone: expected at most %.6g (nine tenths of the smaller of the half widths), found %g", most, zone); wrong = 1;
EndIf
// A face that is too steep is to be mended first, and rises less then.
width = Min(upper_width, 0.9 * radius);
rise = radius - Sqrt(radius^2 - width^2);
least = rise + 0.1 * width;
If (upper_height < least)
  Error("upper_height: expected at least %.6g (the face rises by %.6g and the body needs a side), found %g", least, rise, upper_height); wrong = 1;
EndIf
most = zone / 2;
If (size > most)
  Error("size: expected at most %.6g (half of zone), found %g", most, size); wrong = 1;
EndIf
most = length / 4;
If (end_size > most)
  Error("end_size: expected at most %.6g (a quarter of length), found %g", most, end_size); wrong = 1;
EndIf
If (length_size < end_size)
  Error("length_size: expected at least %.6g (end_size), found %g", end_size, length_size); wrong = 1;
EndIf
If (overhang > 0 && overhang < end_size)
  Error("overhang: expected 0, or at least %.6g (end_size), found %g", end_size, overhang); wrong = 1;
EndIf

// Everything from here to the end of the file is drawn only if nothing is wrong.
If (!wrong)

SetFactory("OpenCASCADE");

For up In {1 : -1 : -2}
  If (up > 0)
    width = upper_width; height = upper_height; coarser = 1; thicker = 1; beyond = 0;
    zone_y = radius - Sqrt(radius^2 - zone^2);
    face_y = radius - Sqrt(radius^2 - width^2);
  Else
    width = lower_width; height = lower_height; coarser = 1.07; thicker = 1.1; beyond = overhang;
    zone_y = 0;
    face_y = 0;
  EndIf

  // The section at the back, from the left end of the face on.
  start = -length / 2 - beyond;
  p = newp;
  Point(p)     = {-width, face_y, start};
  Point(p + 1) = {-zone, zone_y, start};
  Point(p + 2) = {zone, zone_y, start};
  Point(p + 3) = {width, face_y, start};
  Point(p + 4) = {width, up * height, start};
  Point(p + 5) = {-width, up * height, start};
  c = newc;
  If (up > 0)
    centre = newp; Point(centre) = {0, radius, start};
    Circle(c)     = {p, centre, p + 1};
    Circle(c + 1) = {p + 1, centre, p + 2};
    Circle(c + 2) = {p + 2, centre, p + 3};
  Else
    Line(c)     = {p, p + 1};
    Line(c + 1) = {p + 1, p + 2};
    Line(c + 2) = {p + 2, p + 3};
  EndIf
  Line(c + 3) = {p + 3, p + 4};
  Line(c + 4) = {p + 4, p + 5};
  Line(c + 5) = {p + 5, p};
  // Even along the contact: with a node on the line where the bodies touch only in the upper one, as
  // Gmsh makes one node of two that it sweeps to the same place.
  Transfinite Curve {c + 1} = (up > 0) ? 2 * Ceil(zone / size) + 1 : 2 * Ceil(zone / size / coarser - 0.5) + 2;
  s = news;
  Curve Loop(s) = {c : c + 5};
  Plane Surface(s) = {s};

  // Swept beyond the back end of the contact, along it, and beyond its front end. Layers grow from an
  // end of the contact on, as many as fit, and are scaled to fill the length.
  back[] = {s};
  volumes[] = {};
  walls[] = {};
  For part In {0 : 2}
    extent = (part == 1) ? length / 2 : beyond;
    ends[] = {};
    reached = 0;
    thickness = thicker * end_size;
    For i In {1 : 10000}
      If (reached < extent - thickness / 3)
        reached += thickness;
        ends[] += {reached};
        thickness = Min(thickness * (1 + growth), thicker * length_size);
      EndIf
    EndFor
    number = #ends[];
    steps[] = {};
    If (part == 0)
      For i In {2 : number}
        steps[] += {1 - ends[number - i] / reached};
      EndFor
      steps[] += {1};
    EndIf
    If (part == 1)
      For i In {0 : number - 1}
        steps[] += {ends[i] / reached / 2};
      EndFor
      For i In {2 : number}
        steps[] += {1 - ends[number - i] / reached / 2};
      EndFor
      steps[] += {1};
      extent = length;
    EndIf
    If (part == 2)
      For i In {0 : number - 1}
        steps[] += {ends[i] / reached};
      EndFor
    EndIf
    If (extent > 0)
      ones[] = {};
      For i In {1 : #steps[]}
        ones[] += {1};
      EndFor
      swept[] = Extrude {0, 0, extent} { Surface{s}; Layers{ones[], steps[]}; };
      s = swept[0];
      volumes[] += {swept[1]};
      walls[] += {swept[{2 : 7}]};
      If (part == 1)
        contact = swept[3];
      EndIf
    EndIf
  EndFor

  // Walls in the order of the curves of the section: face, contact, face, right, end, left.
  right[] = {};
  end[] = {};
  left[] = {};
  For i In {0 : #volumes[] - 1}
    right[] += {walls[6 * i + 3]};
    end[] += {walls[6 * i + 4]};
    left[] += {walls[6 * i + 5]};
  EndFor
  If (up > 0)
    Physical Volume("upper") = {volumes[]};
    Physical Surface("upper_contact") = {contact};
    Physical Surface("upper_top") = {end[]};
    Physical Surface("upper_back") = {back[]};
    Physical Surface("upper_front") = {s};
  Else
    Physical Volume("lower") = {volumes[]};
    Physical Surface("lower_contact") = {contact};
    Physical Surface("lower_bottom") = {end[]};
    Physical Surface("lower_left") = {left[]};
    Physical Surface("lower_right") = {right[]};
    Physical Surface("lower_back") = {back[]};
    Physical Surface("lower_front") = {s};
  EndIf

  // Element size in the section: the distance is that from the candidate contact in the plane y = 0.
  // Elements are not larger than half of the half width of a body.
  f = (up > 0) ? 1 : 3;
  Field[f] = MathEval;
  Field[f].F = Sprintf("%g * Min(%g + %g * Sqrt(Max(Abs(x) - %g, 0)^2 + y^2), %g)",
    coarser, size, growth, zone, width / 2);
  Field[f + 1] = Restrict;
  Field[f + 1].InField = f;
  Field[f + 1].VolumesList = {volumes[]};
EndFor
Field[5] = Min;
Field[5].FieldsList = {2, 4};
Background Field = 5;
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeFromCurvature = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.Algorithm = 6;

EndIf

// Half (y >= 0) of the fluke and crown of an articulated stockless anchor in the manner of the AC-14, drawn flat along x.
//
//   side view (y = 0)                                plan
//           palm                                        y
//        .--/\--.                                       |  crown     .___
//       (   o    )-----------____                       |__.-------.'    ''--..
//        '--\/--' hinge          '---> tip                 |  hinge |          '> tip
//           palm                                           '--------'______--''
//
// The origin is that of the published model: the hinge on the shank (ac14_shank.geo, in the same coordinates) is at
// x = 0.489, the centre of mass at x = 0.62, and z = 0 is its middle plane. Lengths in metres.
//
// Published for the half fluke: mass 3291.6 kg, moment of inertia about y 275 kg m2, centre (0.62, 0, 0). All dimensions
// but the place of the hinge are chosen here so that steel of 7850 kg/m3 comes near to that.
SetFactory("OpenCASCADE");

DefineConstant[
  hinge           = {0.489, Name "Parameters/hinge"},          // [m] x of the hinge (published)
  tip             = {1.52,  Name "Parameters/tip"},            // [m] x of the tip
  fluke_gap       = {0.30,  Name "Parameters/fluke_gap"},      // [m] y of the inner edge, beside the shank
  fluke_width     = {1.05,  Name "Parameters/fluke_width"},    // [m] of one fluke, at its broadest
  fluke_thickness = {0.375, Name "Parameters/fluke_thickness"},// [m] at the crown
  tip_thickness   = {0.06,  Name "Parameters/tip_thickness"},  // [m]
  crown_width     = {2.66,  Name "Parameters/crown_width"},    // [m] along y, whole anchor
  crown_radius    = {0.25,  Name "Parameters/crown_radius"},   // [m]
  palm_height     = {0.105, Name "Parameters/palm_height"},    // [m] how far the tripping palms stand out
  size            = {0.12,  Name "Parameters/size"}            // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

B = crown_width/2;
R = crown_radius;

// ---- crown: a bar along y -------------------------------------------------------------------------------
Cylinder(1) = {hinge, 0, 0, 0, B, 0, R};

// ---- palms: one lobe through the crown, standing out on both faces ----------------------------------------
// Round: on a plateau half a cell wide, soil lies as deep in the springs of contact as its rounded edges are round.
H = R + palm_height;
Disk(101) = {hinge, 0, 0, H, 0.75*R};
Rotate{ {1, 0, 0}, {hinge, 0, 0}, Pi/2 }{ Surface{101}; }
Rotate{ {0, 1, 0}, {hinge, 0, 0}, Pi/2 }{ Surface{101}; }
palm() = Extrude{0, 0.75*B, 0}{ Surface{101}; };

// ---- fluke: plan swept along z, cut by its side profile ---------------------------------------------------
L = tip - hinge;
yi = fluke_gap;
W = fluke_width;
p = newp;
Point(p)   = {hinge, yi, -1};
Point(p+1) = {hinge + 0.70*L, yi + 0.10*W, -1};
Point(p+2) = {tip, yi + 0.42*W, -1};
Point(p+3) = {hinge + 0.62*L, yi + 0.86*W, -1};
Point(p+4) = {hinge, yi + W, -1};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p};
Curve Loop(201) = {l:l+4};
Plane Surface(201) = {201};
plan() = Extrude{0, 0, 2}{ Surface{201}; };

t = fluke_thickness/2;
e = tip_thickness/2;
p = newp;
Point(p)   = {hinge, 0, -t};
Point(p+1) = {tip, 0, -e};
Point(p+2) = {tip, 0, e};
Point(p+3) = {hinge, 0, t};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p};
Curve Loop(301) = {l:l+3};
Plane Surface(301) = {301};
side() = Extrude{0, 2*(yi + W), 0}{ Surface{301}; };
fluke() = BooleanIntersection{ Volume{plan(1)}; Delete; }{ Volume{side(1)}; Delete; };

// ---- one solid --------------------------------------------------------------------------------------------
body() = BooleanUnion{ Volume{1}; Delete; }{ Volume{palm(1)}; Volume{fluke()}; Delete; };

// ---- named groups -----------------------------------------------------------------------------------------
d = 1e-3;
cut() = Surface In BoundingBox{-10, -d, -10, 10, d, 10};
skin() = Abs(Boundary{ Volume{body()}; });
skin() -= cut();
Physical Volume("body") = body();
Physical Surface("contact") = skin();
Physical Surface("symmetry") = cut();
yt = yi + 0.42*W;
Physical Point("tip") = Point In BoundingBox{tip - d, yt - d, -e - d, tip + d, yt + d, -e + d};

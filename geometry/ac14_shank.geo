// Half (y >= 0) of the shank of an articulated stockless anchor in the manner of the AC-14, drawn flat along x.
//
//   side view (y = 0)                           plan
//          ____------____                          y
//     <----              ----> shackle             |__----------__
//          ----______----                          '--------------'---> x
//     hinge
//
// The origin is that of the published model: the hinge on the fluke (ac14_fluke.geo, in the same coordinates) is at
// x = 0.489, the shackle at x = 3.0294, and z = 0 is its middle plane. Lengths in metres.
//
// Published for the half shank: mass 1058.4 kg, moment of inertia about y 337.5 kg m2, centre (1.7592, 0, 0): less than
// that of a bar, so it is thick in its middle. All other dimensions are chosen here, for steel of 7850 kg/m3.
SetFactory("OpenCASCADE");

DefineConstant[
  hinge        = {0.489,  Name "Parameters/hinge"},        // [m] x of the hinge (published)
  shackle      = {3.0294, Name "Parameters/shackle"},      // [m] x of the shackle (published)
  width        = {0.52,   Name "Parameters/width"},        // [m] along y, whole anchor, in the middle
  end_width    = {0.205,  Name "Parameters/end_width"},    // [m] the same at both ends
  height       = {0.40,   Name "Parameters/height"},       // [m] along z, in the middle
  end_height   = {0.16,   Name "Parameters/end_height"},   // [m] the same at both ends
  size         = {0.12,   Name "Parameters/size"}          // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

m = (hinge + shackle)/2;
h = height/2;
g = end_height/2;
c = g/2;                                 // chamfer of the ends
w = width/2;
v = end_width/2;

// ---- side profile swept along y, and plan swept along z ---------------------------------------------------
p = newp;
Point(p)   = {hinge, 0, 0};
Point(p+1) = {hinge + c, 0, -g};
Point(p+2) = {m, 0, -h};
Point(p+3) = {shackle - c, 0, -g};
Point(p+4) = {shackle, 0, 0};
Point(p+5) = {shackle - c, 0, g};
Point(p+6) = {m, 0, h};
Point(p+7) = {hinge + c, 0, g};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p+5};
Line(l+5) = {p+5, p+6};
Line(l+6) = {p+6, p+7};
Line(l+7) = {p+7, p};
Curve Loop(101) = {l:l+7};
Plane Surface(101) = {101};
side() = Extrude{0, 1, 0}{ Surface{101}; };

p = newp;
Point(p)   = {hinge - 1, 0, -1};
Point(p+1) = {shackle + 1, 0, -1};
Point(p+2) = {shackle + 1, v, -1};
Point(p+3) = {shackle, v, -1};
Point(p+4) = {m, w, -1};
Point(p+5) = {hinge, v, -1};
Point(p+6) = {hinge - 1, v, -1};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p+5};
Line(l+5) = {p+5, p+6};
Line(l+6) = {p+6, p};
Curve Loop(201) = {l:l+6};
Plane Surface(201) = {201};
plan() = Extrude{0, 0, 2}{ Surface{201}; };

body() = BooleanIntersection{ Volume{side(1)}; Delete; }{ Volume{plan(1)}; Delete; };

// ---- named groups -----------------------------------------------------------------------------------------
d = 1e-3;
cut() = Surface In BoundingBox{-10, -d, -10, 10, d, 10};
skin() = Abs(Boundary{ Volume{body()}; });
skin() -= cut();
Physical Volume("body") = body();
Physical Surface("contact") = skin();
Physical Surface("symmetry") = cut();
Physical Point("hinge") = Point In BoundingBox{hinge - d, -d, -d, hinge + d, d, d};
Physical Point("shackle") = Point In BoundingBox{shackle - d, -d, -d, shackle + d, d, d};

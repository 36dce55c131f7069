// Half (y >= 0) of a stockless drag anchor in the manner of the AC-14, about its symmetry plane y = 0.
//
//   side view (y = 0)                                   plan of the fluke, in its own plane
//
//        crown        shank                                  y
//        .--.______________________________                  |   crown   outer edge
//       ( o  )_____________________________) shackle         |__.-------.___
//        '\ /                                                |  |            ''--..
//          \ \   ) opening angle                             |  |                  '> tip
//           \ \                                              |  |________.--- ' '
//            \_\  tip                                        |__|  inner edge (beside the shank)
//
// The origin is the crown pin, where the fluke would turn on the shank; here the two are one rigid solid,
// fixed at the opening angle. The shank lies along +x, the way it is pulled, and the fluke points forward
// and down (-z), so that the tip digs in. Lengths in metres, angles in degrees.
//
// Published for an AC-14 used as a drag anchor: fluke length 1.7 m, shank length 3.3 m, opening angle 35
// degrees, mass of the half fluke and crown 3291.6 kg, of the shank 1058.4 kg (4350 kg together). All other
// dimensions are chosen here, in the proportions of the type; steel of 7850 kg/m3 then gives 4346 kg, the
// shank 1083 kg of it.
SetFactory("OpenCASCADE");

DefineConstant[
  shank_length    = {3.3,  Name "Parameters/shank_length"},    // [m] crown pin to shackle (published)
  shank_width     = {0.30, Name "Parameters/shank_width"},     // [m] along y, whole anchor, at the crown
  shank_height    = {0.37, Name "Parameters/shank_height"},    // [m] along z, at the crown
  shank_taper     = {0.70, Name "Parameters/shank_taper"},     // [-] shackle end over crown end
  fluke_length    = {1.7,  Name "Parameters/fluke_length"},    // [m] crown pin to tip (published)
  fluke_width     = {0.86, Name "Parameters/fluke_width"},     // [m] of one fluke, at its broadest
  fluke_thickness = {0.31, Name "Parameters/fluke_thickness"}, // [m] at the crown
  tip_thickness   = {0.08, Name "Parameters/tip_thickness"},   // [m]
  fluke_gap       = {0.06, Name "Parameters/fluke_gap"},       // [m] clearance between fluke and shank
  crown_width     = {2.20, Name "Parameters/crown_width"},     // [m] along y, whole anchor
  crown_height    = {0.54, Name "Parameters/crown_height"},    // [m] diameter of its rounded back
  palm_height     = {0.15, Name "Parameters/palm_height"},     // [m] how far the tripping palms stand out
  opening_angle   = {35,   Name "Parameters/opening_angle"},   // [deg] between shank and fluke (published)
  size            = {0.11, Name "Parameters/size"}             // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
Geometry.OCCUnionUnify = 0;   // keeps the vertex at the shackle, where two arcs of one circle meet

// Each part is the common volume of prisms: a side profile swept along y, a plan swept along z, a front view
// swept along x. That keeps every face plane or singly curved, and the Booleans robust.

// ---- shank: side profile with a rounded end, plan tapering toward the shackle ---------------------------
hs = shank_height/2;
ws = shank_width/2;
r = hs*shank_taper;                      // radius of the shackle end

p = newp;
Point(p)   = {0, 0, -hs};
Point(p+1) = {shank_length - r, 0, -r};
Point(p+2) = {shank_length - r, 0, 0};   // centre of the end
Point(p+3) = {shank_length, 0, 0};       // the shackle
Point(p+4) = {shank_length - r, 0, r};
Point(p+5) = {0, 0, hs};
l = newl;
Line(l)     = {p, p+1};
Circle(l+1) = {p+1, p+2, p+3};
Circle(l+2) = {p+3, p+2, p+4};
Line(l+3)   = {p+4, p+5};
Line(l+4)   = {p+5, p};
Curve Loop(1) = {l:l+4};
Plane Surface(1) = {1};
shank_side() = Extrude{0, ws, 0}{ Surface{1}; };

p = newp;
Point(p)   = {-hs, 0, -2*hs};
Point(p+1) = {shank_length + hs, 0, -2*hs};
Point(p+2) = {shank_length + hs, ws*shank_taper, -2*hs};
Point(p+3) = {0.2*shank_length, ws, -2*hs};
Point(p+4) = {-hs, ws, -2*hs};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p};
Curve Loop(101) = {l:l+4};
Plane Surface(101) = {101};
shank_plan() = Extrude{0, 0, 4*hs}{ Surface{101}; };

shank() = BooleanIntersection{ Volume{shank_side(1)}; Delete; }{ Volume{shank_plan(1)}; Delete; };

// ---- fluke, drawn with its middle plane at z = 0, turned to the opening angle at the end ----------------
L = fluke_length;
yi = ws + fluke_gap;                     // inner edge, beside the shank
W = fluke_width;

p = newp;
Point(p)   = {0, yi, -1};
Point(p+1) = {0.50*L, yi, -1};
Point(p+2) = {0.80*L, yi + 0.11*W, -1};
Point(p+3) = {L, yi + 0.36*W, -1};       // tip
Point(p+4) = {0.88*L, yi + 0.59*W, -1};
Point(p+5) = {0.66*L, yi + 0.82*W, -1};
Point(p+6) = {0.38*L, yi + 0.97*W, -1};
Point(p+7) = {0.10*L, yi + W, -1};
Point(p+8) = {0, yi + W, -1};
l = newl;
Line(l)     = {p, p+1};
BSpline(l+1) = {p+1, p+2, p+3};
BSpline(l+2) = {p+3, p+4, p+5, p+6, p+7};
Line(l+3)   = {p+7, p+8};
Line(l+4)   = {p+8, p};
Curve Loop(201) = {l:l+4};
Plane Surface(201) = {201};
fluke_plan() = Extrude{0, 0, 2}{ Surface{201}; };

p = newp;
Point(p)   = {0, 0, -fluke_thickness/2};
Point(p+1) = {1.1*L, 0, -(tip_thickness - 0.1*(fluke_thickness - tip_thickness))/2};
Point(p+2) = {1.1*L, 0, (tip_thickness - 0.1*(fluke_thickness - tip_thickness))/2};
Point(p+3) = {0, 0, fluke_thickness/2};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p};
Curve Loop(301) = {l:l+3};
Plane Surface(301) = {301};
fluke_side() = Extrude{0, 2*(yi + W), 0}{ Surface{301}; };

fluke() = BooleanIntersection{ Volume{fluke_plan(1)}; Delete; }{ Volume{fluke_side(1)}; Delete; };

// ---- crown: rounded back, palms above and below, narrowing toward its ends ------------------------------
R = crown_height/2;
B = crown_width/2;

p = newp;
Point(p)   = {0, 0, -R};
Point(p+1) = {0, 0, 0};
Point(p+2) = {-R, 0, 0};
Point(p+3) = {0, 0, R};
Point(p+4) = {0.35*R, 0, R};
Point(p+5) = {1.1*R, 0, 0.45*R};
Point(p+6) = {1.1*R, 0, -0.45*R};
Point(p+7) = {0.35*R, 0, -R};
l = newl;
Circle(l)   = {p, p+1, p+2};
Circle(l+1) = {p+2, p+1, p+3};
Line(l+2)   = {p+3, p+4};
Line(l+3)   = {p+4, p+5};
Line(l+4)   = {p+5, p+6};
Line(l+5)   = {p+6, p+7};
Line(l+6)   = {p+7, p};
Curve Loop(401) = {l:l+6};
Plane Surface(401) = {401};
crown_side() = Extrude{0, B, 0}{ Surface{401}; };

p = newp;
Point(p)   = {-2*R, 0, -R};
Point(p+1) = {-2*R, 0.45*B, -R};
Point(p+2) = {-2*R, B, -0.62*R};
Point(p+3) = {-2*R, B, 0.62*R};
Point(p+4) = {-2*R, 0.45*B, R};
Point(p+5) = {-2*R, 0, R};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p+5};
Line(l+5) = {p+5, p};
Curve Loop(501) = {l:l+5};
Plane Surface(501) = {501};
crown_front() = Extrude{4*R, 0, 0}{ Surface{501}; };

p = newp;
Point(p)   = {-2*R, 0, -2*R};
Point(p+1) = {2*R, 0, -2*R};
Point(p+2) = {2*R, B, -2*R};
Point(p+3) = {-0.15*R, B, -2*R};
Point(p+4) = {-0.70*R, 0.78*B, -2*R};
Point(p+5) = {-R, 0.40*B, -2*R};
Point(p+6) = {-2*R, 0.40*B, -2*R};
l = newl;
Line(l)     = {p, p+1};
Line(l+1)   = {p+1, p+2};
Line(l+2)   = {p+2, p+3};
Spline(l+3) = {p+3, p+4, p+5};
Line(l+4)   = {p+5, p+6};
Line(l+5)   = {p+6, p};
Curve Loop(601) = {l:l+5};
Plane Surface(601) = {601};
crown_plan() = Extrude{0, 0, 4*R}{ Surface{601}; };

crown() = BooleanIntersection{ Volume{crown_side(1)}; Delete; }{ Volume{crown_front(1)}; Delete; };
crown() = BooleanIntersection{ Volume{crown()}; Delete; }{ Volume{crown_plan(1)}; Delete; };

// palms: one wedge through the crown, standing out on both faces
H = R + palm_height;
p = newp;
Point(p)   = {-0.40*R, 0, -0.3*R};
Point(p+1) = {-0.10*R, 0, -H};
Point(p+2) = {0.35*R, 0, -H};
Point(p+3) = {0.80*R, 0, -0.3*R};
Point(p+4) = {0.80*R, 0, 0.3*R};
Point(p+5) = {0.35*R, 0, H};
Point(p+6) = {-0.10*R, 0, H};
Point(p+7) = {-0.40*R, 0, 0.3*R};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p+5};
Line(l+5) = {p+5, p+6};
Line(l+6) = {p+6, p+7};
Line(l+7) = {p+7, p};
Curve Loop(701) = {l:l+7};
Plane Surface(701) = {701};
palm_side() = Extrude{0, B, 0}{ Surface{701}; };

p = newp;
Point(p)   = {-2*R, 0.20*B, 0};
Point(p+1) = {-2*R, 0.34*B, -H};
Point(p+2) = {-2*R, 0.66*B, -H};
Point(p+3) = {-2*R, 0.80*B, 0};
Point(p+4) = {-2*R, 0.66*B, H};
Point(p+5) = {-2*R, 0.34*B, H};
l = newl;
Line(l)   = {p, p+1};
Line(l+1) = {p+1, p+2};
Line(l+2) = {p+2, p+3};
Line(l+3) = {p+3, p+4};
Line(l+4) = {p+4, p+5};
Line(l+5) = {p+5, p};
Curve Loop(801) = {l:l+5};
Plane Surface(801) = {801};
palm_front() = Extrude{4*R, 0, 0}{ Surface{801}; };

palm() = BooleanIntersection{ Volume{palm_side(1)}; Delete; }{ Volume{palm_front(1)}; Delete; };

// ---- one solid ------------------------------------------------------------------------------------------
Rotate{{0, 1, 0}, {0, 0, 0}, opening_angle*Pi/180}{ Volume{fluke(), crown(), palm()}; }
body() = BooleanUnion{ Volume{shank()}; Delete; }{ Volume{fluke(), crown(), palm()}; Delete; };

// ---- named groups ---------------------------------------------------------------------------------------
e = 1e-3;
far = 10*(shank_length + crown_width);
cut() = Surface In BoundingBox{-far, -e, -far, far, e, far};
skin() = Abs(Boundary{ Volume{body()}; });
skin() -= cut();
Physical Volume("body") = body();
Physical Surface("contact") = skin();
Physical Surface("symmetry") = cut();

c = Cos(opening_angle*Pi/180);
s = Sin(opening_angle*Pi/180);
at = tip_thickness/2;                    // lower edge of the tip
xt = L*c - at*s;
yt = yi + 0.36*W;
zt = -L*s - at*c;
Physical Point("shackle") = Point In BoundingBox{shank_length - e, -e, -e, shank_length + e, e, e};
Physical Point("tip") = Point In BoundingBox{xt - e, yt - e, zt - e, xt + e, yt + e, zt + e};

// Block with a V-shaped notch along y in its bottom, its box centred at the origin. Lengths in metres, angle in
// degrees.
//
//      .-----------------.
//      |       /\ angle  |      z
//      |      /  \       |      |
//      '-----'    '------'      '-- x
SetFactory("OpenCASCADE");

DefineConstant[
  length = {1.0, Name "Parameters/length"},  // [m] along x
  width  = {1.0, Name "Parameters/width"},   // [m] along y
  height = {1.0, Name "Parameters/height"},  // [m] along z
  mouth  = {0.4, Name "Parameters/mouth"},   // [m] width of the notch at the bottom, below length
  angle  = {90,  Name "Parameters/angle"},   // [deg] between its flanks; its depth stays below height
  size   = {0.5, Name "Parameters/size"}     // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

depth = mouth/2/Tan(angle/2*Pi/180);

Point(1) = {-length/2, -width/2, -height/2};
Point(2) = {-mouth/2, -width/2, -height/2};
Point(3) = {0, -width/2, -height/2 + depth};
Point(4) = {mouth/2, -width/2, -height/2};
Point(5) = {length/2, -width/2, -height/2};
Point(6) = {length/2, -width/2, height/2};
Point(7) = {-length/2, -width/2, height/2};
For i In {1:6}
  Line(i) = {i, i+1};
EndFor
Line(7) = {7, 1};
Curve Loop(1) = {1:7};
Plane Surface(1) = {1};
out[] = Extrude{0, width, 0}{ Surface{1}; };

Physical Volume("body") = {out[1]};
Physical Surface("contact") = Abs(Boundary{ Volume{out[1]}; });

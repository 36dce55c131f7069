// Straight blade that is dragged towards positive x, the front edge of its foot at the origin. Lengths in metres.
// Parts of its surface: face, which pushes the soil, and foot, underneath.
SetFactory("OpenCASCADE");

DefineConstant[
  width     = {0.8, Name "Parameters/width"},      // [m] along y
  height    = {1.4, Name "Parameters/height"},     // [m] along z
  thickness = {0.2, Name "Parameters/thickness"},  // [m] along x
  rake      = {90,  Name "Parameters/rake"},       // [deg] of the face to the ground in front of it: 90 upright, less leans back
  size      = {0.2, Name "Parameters/size"}        // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

back = height / Tan(rake * Pi / 180);

Point(1) = {0, -width/2, 0};
Point(2) = {-back, -width/2, height};
Point(3) = {-back - thickness, -width/2, height};
Point(4) = {-thickness, -width/2, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
made() = Extrude {0, width, 0} { Surface{1}; };   // end, volume, then a side for each line

Physical Volume("body") = {made(1)};
Physical Surface("contact") = Abs(Boundary{ Volume{made(1)}; });
Physical Surface("face") = {made(2)};
Physical Surface("foot") = {made(5)};

// Solid penetrometer: a cone under a round shaft, tip at the origin, axis along z. Lengths in metres.
SetFactory("OpenCASCADE");

DefineConstant[
  radius = {0.1, Name "Parameters/radius"},  // [m] of the shaft
  angle  = {60,  Name "Parameters/angle"},   // [deg] at the tip, between opposite sides
  shaft  = {1.0, Name "Parameters/shaft"},   // [m] length of the shaft
  size   = {0.03, Name "Parameters/size"}    // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

height = radius / Tan(angle * Pi / 360);

Cone(1) = {0, 0, 0, 0, 0, height, 0, radius};
Cylinder(2) = {0, 0, height, 0, 0, shaft, radius};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };

Physical Volume("body") = {3};
Physical Surface("contact") = Abs(Boundary{ Volume{3}; });

// Solid circular cylinder centred at the origin, axis along z. Lengths in metres.
SetFactory("OpenCASCADE");

DefineConstant[
  radius = {0.25, Name "Parameters/radius"},  // [m]
  height = {1.0,  Name "Parameters/height"},  // [m] along z
  size   = {0.1,  Name "Parameters/size"}     // [m] edge length of the tetrahedra
];

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

Cylinder(1) = {0, 0, -height/2, 0, 0, height, radius};

Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });

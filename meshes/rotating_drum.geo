// A drum of radius 1 cm (cases/rotating_drum.edp); the name of the physical curve is the boundary.
size = 1/24;     // of the elements, cm
sides = Floor(2*Pi/size + 0.5); // of the polygon: an edge each, to which the velocity of the circle is tangential at its midpoint
Point(1) = {0, 0, 0, size};
For k In {0 : sides - 1}
    Point(2 + k) = {Cos(2*Pi*k/sides), Sin(2*Pi*k/sides), 0, size};
EndFor
For k In {0 : sides - 1}
    Line(1 + k) = {2 + k, 2 + (k + 1) % sides};
EndFor
Transfinite Curve {1 : sides} = 2;
Curve Loop(1) = {1 : sides};
Plane Surface(1) = {1};
Physical Curve("wall") = {1 : sides};
Physical Surface("fluid") = {1};

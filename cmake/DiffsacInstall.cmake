# cmake --install and find_package(diffsac).
